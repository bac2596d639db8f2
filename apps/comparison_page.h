// SPDX-License-Identifier: Apache-2.0
// What `compare` and `calibrate` show of a limb against a recording: the same words, tables, pictures and JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "diagnose/compare.h"
#include "report/page.h"

namespace sinew::apps {

// RMSE per channel, fitted and not fitted, with noise, bias and the share that is more than noise.
report::Table error_table(const diagnose::Comparison& comparison);

// The same for programs: a map from column to noise and errors.
nlohmann::ordered_json channels_json(const diagnose::Comparison& comparison);

// One sentence per channel: how far off, when most of it happens.
std::vector<std::string> findings(const diagnose::Comparison& comparison);

// Linked plots over time, residuals against temperature and angle, temperature-angle loops.
std::vector<report::Block> comparison_blocks(const diagnose::Comparison& comparison, const sim::Recording& recording);

// The stacked figure for papers.
std::vector<report::TimePlot> paper_figure(const diagnose::Comparison& comparison, const sim::Recording& recording);

// What a reader looks for first: channels that lie last in the chain of causes, then what drives them.
std::vector<plant::ChannelId> in_reading_order(const plant::System& system);
// A colour for each of a list, the same at every place.
std::string colour(std::size_t i);
// One line for each input.
std::vector<report::Series> input_lines(const plant::System& system, const sim::Recording& recording);

// What the inputs are, in a word: "duty"; "inputs" where they are not of one kind.
std::string input_words(const plant::System& system);

// --noise: one value for each channel, in their order, or NAME=VALUE for some; the others are as estimated. Throws InputError.
diagnose::PerChannel noise_of_option(const std::vector<std::string>& given, const plant::System& system,
                                     const diagnose::PerChannel& estimated);

// A recording that a plant is fitted to or compared with, refused where one of its columns is not what its name says, and where nothing
// is measured in it. Throws InputError.
sim::Recording read_recording_of(const std::string& path, const plant::Plant& plant);
// By option, the recordings that it names. A recording twice would count its evidence twice, and one that is both fitted and held out
// proves nothing. Throws sim::InputError.
void check_given_once(const std::vector<std::pair<std::string, std::vector<std::string>>>& recordings);
void check_recording(const sim::Recording& recording, const plant::Plant& plant);  // the same, of one that is read
void check_columns(const sim::Recording& recording, const plant::Plant& plant);    // of that, what columns are

// What is said of a recording before anything is made of it, a sentence each: what it is too poor for (where it is `alone`: another
// recording may have what this one lacks), pauses, rows that look misread.
std::vector<std::string> doubts_of(const plant::Plant& plant, const sim::Recording& recording, const diagnose::PerChannel& noise,
                                   bool alone = true);
// All that is odd about a recording: what was noted in reading it, and then the doubts.
std::vector<std::string> oddities_of(const plant::Plant& plant, const sim::Recording& recording, const diagnose::PerChannel& noise,
                                     bool alone = true);

// Where none says when it was made, the first one's own time is the clock: of its parts between pauses, and of no other recording.
void count_from_first(std::vector<sim::Recording>& recordings);
// Its parts between pauses, without those of fewer than 20 samples, which nothing is fitted to. At least one: the whole, where none is
// longer.
std::vector<sim::Recording> usable_parts(const sim::Recording& recording);
inline constexpr std::size_t least_samples = 20;  // of a recording, or a part, that are fitted or held out
// Throw InputError where fewer of a recording would be fitted; where --fit-until keeps fewer of each back.
void check_long_enough(const sim::Recording& recording, double fit_until_s);
void check_keeps_back(const std::vector<sim::Recording>& recordings, double fit_until_s);
// Throws InputError where so many samples would be fitted at once that memory may not do: about 5 kB each. `what_to_do`: a clause.
void check_fitted_samples(std::size_t count, const std::string& first_recording,
                          const std::string& what_to_do = "--fit-until takes the first part of a recording");
// Their samples, one part after the other: what is compared and shown.
sim::Recording joined(const sim::Recording& recording, const std::vector<sim::Recording>& parts);

}  // namespace sinew::apps
