// SPDX-License-Identifier: Apache-2.0
// sinew export-fmu: a plant as a Functional Mock-up Unit, for other simulators.
#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "apps/app.h"
#include "apps/limb_link.h"
#include "apps/outputs.h"
#include "fmu/archive.h"
#include "fmu/description.h"
#include "fmu/variables.h"
#include "sim/input_error.h"
#include "sim/manifest.h"
#include "sim/plant_file.h"
#include "sim/text.h"

namespace sinew::apps {
namespace {

struct ExportArguments {
  std::string plant, out, name;
  bool overwrite = false;
};

// ASCII alone, whatever the locale.
bool may_stand_in_identifier(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_'; }

bool is_identifier(const std::string& name) {
  return !name.empty() && !(name.front() >= '0' && name.front() <= '9') && std::all_of(name.begin(), name.end(), may_stand_in_identifier);
}

std::string identifier_of(std::string stem) {
  for (char& c : stem)
    if (!may_stand_in_identifier(c)) c = '_';
  return is_identifier(stem) ? stem : "plant_" + stem;
}

void export_command(const ExportArguments& arguments) {
  const std::string name = arguments.name.empty() ? identifier_of(std::filesystem::path(arguments.plant).stem().string()) : arguments.name;
  if (!is_identifier(name))
    throw sim::InputError(
        {.key = "--name", .value = name, .advice = "must be letters, digits and underscores, and not begin with a digit"});
  const std::string out = arguments.out.empty() ? name + ".fmu" : arguments.out;
  check_output_file(out, {.yaml = {arguments.plant}}, arguments.overwrite);
  const plant::Plant plant = sim::read_plant_file(arguments.plant);
  const std::string tool = "Sinew " + sim::this_build().version, text = sim::plant_file_text(plant);
  const std::string guid = "{" + sim::sha256(name + "\n" + tool + "\n" + text).substr(0, 32) + "}";
  const std::string plant_file =
      "# The plant of an FMU, by " + tool + ": what it was made of, with its bases resolved.\n" + fmu::guid_line + guid + "\n" + text;
  const auto built = [](const char* file) { return sim::read_file(program_beside(file, "it is built with the rest")); };
  sim::write_file_whole(out, fmu::to_zip({{"modelDescription.xml", fmu::model_description(plant, {name, guid, tool})},
                                          {fmu::binary_path(name), built("sinew-fmu.so"), true},
                                          {fmu::plant_path, plant_file},
                                          {"documentation/licenses/license.txt", built("sinew-fmu.licenses.txt")}}));
  std::array<int, 4> count{};
  for (const fmu::Variable& variable : fmu::variables_of(plant)) ++count.at(static_cast<std::size_t>(variable.causality));
  std::printf("%s: inputs %d, outputs %d, states %d, parameters %d\nwritten: %s\n", name.c_str(), count[0], count[1], count[2], count[3],
              out.c_str());
}

}  // namespace

void add_export_fmu(CLI::App& program, int& exit_code) {
  auto arguments = std::make_shared<ExportArguments>();
  CLI::App* command = program.add_subcommand("export-fmu", "Write a plant as an FMU (FMI 2.0, co-simulation) for other simulators.");
  command->add_option("plant", arguments->plant, "plant in YAML: a limb, a machine, or one that diagnose repaired")->required();
  command->add_option("--out", arguments->out, "the file to write; left out: NAME.fmu in this folder");
  command->add_option("--name", arguments->name, "of the model, an identifier of C; left out: made of the plant file's name");
  add_overwrite(*command, arguments->overwrite);
  command->footer(
      "Examples:\n  sinew export-fmu plant/limbs/paper_limb.yaml\n"
      "  sinew export-fmu results/mine/plant.yaml --out limb.fmu --name my_limb");
  command->callback([arguments, &exit_code] {
    export_command(*arguments);
    exit_code = 0;
  });
}

}  // namespace sinew::apps
