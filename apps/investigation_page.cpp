// SPDX-License-Identifier: Apache-2.0
#include "apps/investigation_page.h"

#include <array>
#include <cstdio>

#include "diagnose/channels.h"
#include "plant/contains.h"

namespace sinew::apps {
namespace {

std::string share_words(double probability) {
  char text[24];
  std::snprintf(text, sizeof text, "%.1f %%", 100.0 * probability);
  return text;
}

// One row an answer, one column a recording.
report::Table beliefs_table(const investigate::Investigation& investigation) {
  std::vector<const investigate::Step*> believed;
  std::vector<std::string> answers;
  for (const investigate::Step& step : investigation.steps)
    if (step.after) {
      believed.push_back(&step);
      for (const auto& answer : step.after->answers)
        if (answer.probability >= 0.02 && !contains(answers, answer.key)) answers.push_back(answer.key);
    }
  report::Table table;
  table.title = "What was believed after each recording";
  table.header.push_back("answer");
  table.align.push_back(report::Align::left);
  for (const investigate::Step* step : believed) {
    table.header.push_back(step->name);
    table.align.push_back(report::Align::right);
  }
  for (const std::string& key : answers) {
    report::Row row;
    row.cells.push_back(key);
    for (const investigate::Step* step : believed) {
      double probability = 0.0;
      for (const auto& answer : step->after->answers)
        if (answer.key == key) probability = answer.probability;
      row.cells.push_back(share_words(probability));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

void add_plots(report::Page& page, const std::string& name, const plant::System& system, const sim::Recording& recording) {
  std::vector<double> time_s;
  for (const sim::Sample& sample : recording.samples) time_s.push_back(sample.time_s);
  const auto plot = [&](const std::string& title, const std::string& label, std::vector<report::Series> series) {
    report::TimePlot one;
    one.title = title;
    one.y_label = label;
    one.time_s = time_s;
    one.series = std::move(series);
    one.height_px = 130;
    one.time_axis = name;
    page.blocks.push_back(std::move(one));
  };
  const std::array<const char*, 6> colors{report::okabe_ito::blue,   report::okabe_ito::vermillion, report::okabe_ito::green,
                                          report::okabe_ito::purple, report::okabe_ito::orange,     report::okabe_ito::black};
  std::vector<report::Series> duty;
  for (const plant::InputId i : system.inputs().ids()) {
    std::vector<double> y;
    for (const sim::Sample& sample : recording.samples) y.push_back(sample.inputs[i.index]);
    duty.push_back(report::line(system.inputs()[i].words, y, colors[i.index % colors.size()], report::Series::Style::steps));
  }
  plot("Duty", "duty", std::move(duty));
  std::vector<std::string> kinds;
  for (const plant::ChannelInfo& channel : system.channels())
    if (!contains(kinds, channel.kind)) kinds.push_back(channel.kind);
  for (const std::string& kind : kinds) {
    std::vector<report::Series> series;
    std::string unit;
    for (const plant::ChannelId c : system.channels().ids()) {
      if (system.channels()[c].kind != kind) continue;
      unit = system.channels()[c].unit_words;
      std::vector<double> y;
      for (const sim::Sample& sample : recording.samples) y.push_back(diagnose::measured(sample, c));
      series.push_back(report::line(system.channels()[c].words, y, colors[series.size() % colors.size()]));
    }
    plot("Measured " + kind, kind + " / " + unit, std::move(series));
  }
}

}  // namespace

report::Page investigation_page(const investigate::Investigation& investigation, const plant::System& system,
                                const std::vector<sim::Recording>& recordings) {
  const investigate::Story story = investigate::story_of(investigation, system);
  report::Page page;
  page.title = "Investigation of a limb";
  page.lead = story.end;
  page.blocks.push_back(report::Section{.heading = "What was believed"});
  const report::Table table = beliefs_table(investigation);
  if (!table.rows.empty()) page.blocks.push_back(table);
  if (!story.next.empty()) page.blocks.push_back(report::Section{.heading = "What next", .items = story.next});
  std::size_t recorded = 0;
  for (std::size_t k = 0; k < story.chapters.size(); ++k) {
    page.blocks.push_back(report::Section{.heading = story.chapters[k].heading});
    for (const std::string& paragraph : story.chapters[k].paragraphs) page.blocks.push_back(report::Paragraph{.text = paragraph});
    if (!investigation.steps[k].status || recorded == recordings.size()) continue;
    const sim::Recording& recording = recordings[recorded++];
    if (!recording.samples.empty()) add_plots(page, investigation.steps[k].name, system, recording);
  }
  page.footer.push_back(
      "Probabilities are the diagnosis' own (docs/diagnosis.md) and are not calibrated on whole investigations: docs/investigate.md.");
  return page;
}

}  // namespace sinew::apps
