// SPDX-License-Identifier: Apache-2.0
#include "diagnose/decide.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "plant/contains.h"

namespace sinew::diagnose {
namespace {

// A shape that ends at the bound of what is allowed is no value that a plant has. A bound that stands for nothing (no
// heat loss, friction without smoothing) is one.
bool sensible(plant::EffectId effect, const Explanation& by) {
  for (std::size_t u = 0; u < by.problem->parameters().size(); ++u) {
    const plant::ParameterId p = by.problem->parameters()[u];
    if (by.system().parameters()[p].effect != effect || p == by.system().effects()[effect].strength) continue;
    const Unknown& unknown = by.problem->unknowns()[u];
    const double margin = 1e-6 * (unknown.highest - unknown.lowest);
    const bool lowest_is_nothing = std::abs(unknown.lowest) < 0.02 * std::abs(unknown.centre);
    if ((by.value(u) <= unknown.lowest + margin && !lowest_is_nothing) || by.value(u) >= unknown.highest - margin) return false;
  }
  return true;
}

// Explanations by one effect alone, as the first round fitted them, that take away at least `share` of the core's
// misfit.
std::vector<plant::EffectId> enough_alone(const Search& search, double share) {
  std::vector<plant::EffectId> effects;
  for (const Candidate& candidate : search.rounds.front().candidates)
    if (candidate.explanation.usable && share_explained(search.core, candidate.explanation) >= share) effects.push_back(candidate.effect);
  return effects;
}

}  // namespace

Answer decide(const plant::System& system, Found found, bool stands_in, bool leaves_something) {
  if (found.effects.empty() && found.laws.empty() && found.apart.empty())
    return stands_in || leaves_something ? Answer(Unexplained{}) : Answer(NothingMissing{});
  const std::vector<plant::EffectId> names = names_said(system, found.effects, found.laws);
  found.is_named = !names.empty() || !found.apart.empty();
  found.leaves_something = leaves_something || has_law_beside(system, found.laws, names);
  return found;
}

bool far_off(const plant::System& system, double rmse, plant::ChannelId channel, const PerChannel& noise) {
  return rmse > std::hypot(2.0 * noise[channel], system.channels()[channel].ordinary_disturbance);
}

double share_left(double was, double is, double noise) { return (is * is - noise * noise) / (was * was - noise * noise); }

Objections objections_to(const WithNames& found, bool leaves_too_much, const PerChannel& noise, double visible_process_noise,
                         const Thresholds& thresholds) {
  Objections result;
  result.leaves_too_much = leaves_too_much;
  for (const plant::ChannelId c : noise.ids())
    if (far_off(found.answer.system(), found.after.rmse[c], c, noise) &&
        share_left(found.before.rmse[c], found.after.rmse[c], noise[c]) > thresholds.most_left_of_channel)
      result.channels.push_back(c);
  result.pushes_parameters = found.after.pull > found.before.pull + thresholds.most_rise_of_pull;
  result.patchwork = found.names.size() > 2 && found.answer.process_noise >= visible_process_noise;
  result.at_a_bound = std::any_of(found.names.begin(), found.names.end(), [&](plant::EffectId e) { return !sensible(e, found.answer); });
  return result;
}

Explanation chosen(const Search& search, const SearchSettings& settings, const Thresholds& thresholds) {
  // A name that was taken out, or exchanged for another, after a round had accepted it is no part of any answer.
  const std::vector<plant::EffectId> stands = search.best.effects();
  const auto stands_yet = [&](const Explanation& one) {
    const std::vector<plant::EffectId> effects = one.effects();
    return std::all_of(effects.begin(), effects.end(), [&](plant::EffectId e) { return contains(stands, e); });
  };
  if (search.best.system().laws().size() > search.core.system().laws().size()) return search.best;
  if (nothing_left(search, settings)) {
    const Round* last = nullptr;
    for (const Round& round : search.rounds)
      if (round.accepted) last = &round;
    const auto enough = [&](const Explanation& by) { return share_explained(search.core, by) >= thresholds.least_explained_share; };
    const bool keep = !last || !stands_yet(last->before) || sensible(last->candidates.front().effect, search.best) || !enough(last->before);
    return keep ? search.best : last->before;
  }
  for (const Round& round : search.rounds)
    if (const Explanation& one = round.candidates.front().explanation;
        round.accepted && stands_yet(one) && share_explained(search.core, one) >= thresholds.least_explained_share)
      return one;
  return search.best;
}

Parsimony parsimony_of(const std::vector<plant::EffectId>& effects, const Search& search, bool leaves_something,
                       const Thresholds& thresholds) {
  Parsimony result;
  const auto others = [&](double share) {
    std::vector<plant::EffectId> alone = enough_alone(search, share);
    std::erase_if(alone, [&](plant::EffectId e) { return has_family(search.core.system(), effects, e); });
    return alone;
  };
  if (leaves_something) result.as_good = others(thresholds.least_explained_share);
  // Both kinds of sensor off at once is a coincidence, unless something before both is; also where the second was accepted
  // on the way but did not make it into the answer.
  std::vector<plant::EffectId> accepted = effects;
  for (const Round& round : search.rounds)
    if (round.accepted) accepted.push_back(round.candidates.front().effect);
  const auto& catalogue = search.core.system().effects();
  const auto is_sensor = [&](plant::EffectId e) { return catalogue[e].place.starts_with("sensor."); };
  std::set<std::string_view> sensors;
  for (const plant::EffectId e : accepted)
    if (is_sensor(e)) sensors.insert(catalogue[e].place);
  if (std::all_of(effects.begin(), effects.end(), is_sensor) && sensors.size() > 1) {
    result.common_causes = others(thresholds.named_share);
    std::erase_if(result.common_causes, is_sensor);
  }
  return result;
}

}  // namespace sinew::diagnose
