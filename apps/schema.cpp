// SPDX-License-Identifier: Apache-2.0
// sinew schema: what may stand in a scenario or a plant file, as JSON Schema.
#include <cstdio>
#include <memory>
#include <optional>

#include "apps/app.h"
#include "sim/plant_file.h"
#include "sim/schema.h"

namespace sinew::apps {

void add_schema(CLI::App& program, int& exit_code) {
  struct Arguments {
    std::string what, plant;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program.add_subcommand("schema", "Print the JSON Schema of scenarios or plant files, for editors.");
  command->add_option("what", arguments->what, "scenario or plant")->required()->check(CLI::IsMember({"scenario", "plant"}));
  command->add_option("--plant", arguments->plant,
                      "a plant file of another structure than the usual: its parameters and inputs stand in the schema by name");
  command->footer(
      "Examples:\n  sinew schema scenario > docs/schema/scenario.json\n  sinew schema plant --plant plant/limbs/two_axis_limb.yaml");
  command->callback([arguments, &exit_code] {
    std::optional<plant::Plant> plant;
    if (!arguments->plant.empty()) plant = sim::read_plant_file(arguments->plant);
    const plant::System* system = plant ? &plant->system() : nullptr;
    std::printf("%s\n", (arguments->what == "plant" ? sim::plant_schema(system) : sim::scenario_schema(system)).dump(1).c_str());
    exit_code = 0;
  });
}

}  // namespace sinew::apps
