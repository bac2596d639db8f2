// SPDX-License-Identifier: Apache-2.0
// Water that a heater warms and a room cools:  C dT/dt = P - h (T - T_room)
#include "plant/small_system.h"
#include "plant/systems.h"

namespace sinew::plant {
namespace kettle {

template <class S>
struct Core {
  S heat_capacity_J_K{4200.0}, heat_loss_W_K{1.0}, room_degC{20.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.heat_capacity_J_K, Declaration{.name = "heat_capacity_J_K",
                                              .symbol = "C",
                                              .unit = units::J_K,
                                              .range = {10.0, 1e5},
                                              .typical = 4200.0,
                                              .prior_deviation = 1000.0,
                                              .meaning = "heat that warms it by one kelvin",
                                              .source = "a litre of water"});
    visit(self.heat_loss_W_K, Declaration{.name = "heat_loss_W_K",
                                          .symbol = "h",
                                          .unit = units::W_K,
                                          .range = {0.01, 100.0},
                                          .typical = 1.0,
                                          .prior_deviation = 1.0,
                                          .meaning = "heat lost for each kelvin above the room"});
    visit(self.room_degC, Declaration{.name = "room_degC",
                                      .symbol = "T_room",
                                      .unit = units::degC,
                                      .range = {-20.0, 60.0},
                                      .typical = 20.0,
                                      .meaning = "temperature of the room, read off a thermometer"});
  }
};

template <class S>
struct Now : AtAnInstant<Core<S>> {
  S temperature_degC, power_W, heat_W;

  void input(const S* y) {
    temperature_degC = y[0];
    power_W = AtAnInstant<Core<S>>::input(0);
  }
  void balance() { heat_W = power_W - this->core->heat_loss_W_K * (temperature_degC - this->core->room_degC); }
  void rates(S* rate) const { rate[0] = heat_W / this->core->heat_capacity_J_K; }
  void reading() { this->shown[0] = temperature_degC; }
  void rest(const Known<S>&, S* y) const { y[0] = this->core->room_degC + this->given->input(0) / this->core->heat_loss_W_K; }
};

// Steam carries heat away, the more the hotter.
template <class S>
struct Evaporation : WholePlant {
  static constexpr std::string_view name = "evaporation", place = "thermal", equation = "q -> q - e (T - T_room)^2",
                                    words = "steam carries heat away";
  S loss_W_K2{0.0};

  template <class Self, class Visitor>
  static void parameters(Self& self, Visitor&& visit) {
    visit(self.loss_W_K2, strength("loss_W_K2", "e", Unit{"W/K^2"}, 0.02, 0.05, {0.0, 10.0}, "power for each squared kelvin"));
  }
  void balance(Now<S>& now) const {
    const S above_K = now.temperature_degC - now.core->room_degC;
    now.heat_W -= loss_W_K2 * above_K * above_K;
  }
};

template <class S>
using Effects = std::tuple<Evaporation<S>>;

}  // namespace kettle

std::shared_ptr<const System> make_kettle(const Description& structure, const std::vector<OwnValues>& own) {
  const SmallLists lists{
      .name = "kettle",
      .words = "the kettle",
      .states = {{"temperature_degC", units::degC, 50.0}},
      .inputs = {{.column = "power_W", .name = "heater", .part = "heater", .words = "power", .unit = Unit{"W"}, .range = {0.0, 5000.0}}},
      .channels = {{.info = {.column = "temperature_degC",
                             .words = "temperature",
                             .unit_words = "°C",
                             .unit = units::degC,
                             .range = {-50.0, 200.0},
                             .noise = 0.1,
                             .step = 0.0,
                             .short_name = "temperature",
                             .kind = "temperature"},
                    .shows = "temperature_degC"}},
      .entries = {{.group = {.name = "heat",
                             .words = "the balance of heat",
                             .unit = "W",
                             .typical = 20.0,
                             .correlation_time_s = 60.0,
                             .places = {"thermal"}},
                   .state = "temperature_degC",
                   .divided_by = "heat_capacity_J_K"},
                  {.group = {.name = "reading",
                             .words = "the thermometer's reading",
                             .unit = "K",
                             .typical = 0.5,
                             .correlation_time_s = 60.0,
                             .places = {"sensor"}},
                   .channel = "temperature_degC"}},
      .drives = {{.channel = ChannelId{0}, .input = InputId{0}, .sense = 1.0}}};
  return std::make_shared<SmallSystem<kettle::Core, kettle::Now, kettle::Effects>>(lists, structure, own);
}

}  // namespace sinew::plant
