#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""An independent reference of the plant, written from design/plant.md alone.

    /usr/bin/python3 tests/golden/reference.py            writes every case beside this file
    /usr/bin/python3 tests/golden/reference.py CASE...    writes the named ones

It shares no code with the C++ plant and none of its numerics: scipy's DOP853, restarted wherever the right-hand
side jumps (duty, airflow), rtol 1e-11. What plant.md leaves open is settled below, each time at a line "CHOICE".
"""
import math
import os
import sys

import numpy
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

HERE = os.path.dirname(os.path.abspath(__file__))
DURATION = 60  # s
RTOL = 1e-11

# ---------------------------------------------------------------------------------------------------------------
# The plants

DEFAULTS = {
    "supply_voltage_V": 7.0,
    "resistance_A_Ohm": 2.5,
    "resistance_B_Ohm": 2.5,
    "heat_capacity_A_J_K": 0.85,
    "heat_capacity_B_J_K": 0.85,
    "heat_loss_A_W_K": 0.040,
    "heat_loss_B_W_K": 0.040,
    "ambient_temperature_degC": 25.0,
    "heating_midpoint_degC": 75.0,
    "heating_width_K": 7.0,
    "cooling_midpoint_degC": 60.0,
    "cooling_width_K": 7.0,
    "transformation_time_s": 0.10,
    "austenite_stiffness_N_m": 313.0,
    "martensite_stiffness_N_m": 113.0,
    "coil_stretch_m": 0.030,
    "transformation_stretch_m": 0.028,
    "moment_arm_A_m": 0.006,
    "moment_arm_B_m": 0.006,
    "beam_stiffness_Nm_rad": 0.050,
    "beam_damping_Nms_rad": 0.004,
    "beam_inertia_kgm2": 2.0e-5,
    "angle_offset_deg": 0.0,
    "bend_sign": 1,
}

# Every parameter off its default, A and B unequal, the limb mounted the other way round. The widths differ so that
# the envelopes cross at 18 °C + 12 K = 30 °C, above the ambient: the mean rule is at work at the start.
PERTURBED = {
    "supply_voltage_V": 7.4,
    "resistance_A_Ohm": 2.3,
    "resistance_B_Ohm": 2.7,
    "heat_capacity_A_J_K": 0.80,
    "heat_capacity_B_J_K": 0.92,
    "heat_loss_A_W_K": 0.046,
    "heat_loss_B_W_K": 0.037,
    "ambient_temperature_degC": 22.0,
    "heating_midpoint_degC": 75.0,
    "heating_width_K": 9.0,
    "cooling_midpoint_degC": 60.0,
    "cooling_width_K": 6.0,
    "transformation_time_s": 0.15,
    "austenite_stiffness_N_m": 290.0,
    "martensite_stiffness_N_m": 105.0,
    "coil_stretch_m": 0.031,
    "transformation_stretch_m": 0.027,
    "moment_arm_A_m": 0.0065,
    "moment_arm_B_m": 0.0055,
    "beam_stiffness_Nm_rad": 0.045,
    "beam_damping_Nms_rad": 0.005,
    "beam_inertia_kgm2": 2.5e-5,
    "angle_offset_deg": 2.5,
    "bend_sign": -1,
}

EFFECTS = {
    "junction": {"heat_capacity_J_K": 0.5, "conductance_W_K": 0.06, "relative_power": 0.7, "cooling_rate_1_s": 0.03},
    "junction_layer": {"conductance_W_K": 0.04, "heat_capacity_J_K": 0.6, "heat_loss_W_K": 0.015},
    "thermocouple_lag": {"time_constant_s": 1.5},
    "thermocouple_two_lags": {"time_constant_s": 1.2, "second_share": 0.4},
    "thermocouple_heat_sink": {"gain": 0.85},
    "body_heat_storage": {"conductance_W_K": 0.015, "heat_capacity_J_K": 3.0, "heat_loss_W_K": 0.02},
    "sheath_heat_storage": {"conductance_W_K": 0.04, "heat_capacity_J_K": 1.5, "heat_loss_W_K": 0.025},
    "cross_heating": {"conductance_W_K": 0.008},
    "latent_heat": {"latent_heat_J": 8.0},
    "convection_nonlinearity": {"slope_1_K": 0.004},
    "airflow_change": {"relative_change": 0.5, "onset_s": 23.37},
    "ambient_drift": {"rate_K_s": 0.1},
    "resistance_change": {"relative_increase": 0.2},
    "supply_sag": {"source_resistance_Ohm": 0.3},
    "driver_lag": {"time_constant_s": 0.45},
    "duty_deadband": {"threshold_fraction": 0.08},
    "input_delay": {"delay_s": 0.37},
    "stress_shift": {"shift_K_N": 0.8},
    "stress_shift_curved": {"shift_K_N": 1.2, "slope_slack": 2.2, "slope_taut": 0.3},
    "stress_shift_two_slopes": {"shift_K_N": 0.7, "cooling_ratio": 1.6},
    "fatigue": {"loss_per_cycle": 0.05},
    "minor_loops": {"slope_share": 0.3},
    "r_phase": {"share": 0.25, "midpoint_degC": 45.0, "width_K": 4.0},
    "viscoelastic_creep": {"stiffness_Nm_rad": 0.02, "time_constant_s": 5.0},
    "dry_friction": {"moment_Nm": 0.003, "smoothing_rad_s": 0.05},
    "cubic_stiffening": {"stiffness_Nm_rad3": 0.1},
    "gravity_load": {"moment_Nm": 0.01, "tilt_deg": 20.0},
    "coil_slack": {"enabled": True},
    "hard_stop": {"stiffness_Nm_rad": 0.5, "angle_deg": 14.0},
    "angle_sensor_lag": {"time_constant_s": 0.4},
    "angle_sensor_second_order": {"time_s": 0.25, "damping": 0.6},
    "angle_sensor_saturation": {"saturation_1_rad2": 2.0},
    "angle_sensor_drift": {"rate_deg_s": 0.05},
}


def pick(*names):
    return {name: EFFECTS[name] for name in names}


def cases():
    """name -> (parameters, effects); what is not in parameters has its default."""
    table = {"core": ({}, {}), "core_perturbed": (PERTURBED, {})}
    for name in EFFECTS:
        table[name] = ({}, pick(name))
    # A layer lies round a junction.
    table["junction_layer"] = ({}, pick("junction", "junction_layer"))
    # At the default stretch no coil ever goes slack; shorter ones do.
    table["coil_slack"] = ({"coil_stretch_m": 0.024}, pick("coil_slack"))
    table["combination_electric"] = (
        PERTURBED,
        pick("resistance_change", "supply_sag", "duty_deadband", "input_delay", "angle_sensor_lag", "angle_sensor_drift"),
    )
    table["combination_coil"] = (
        {**PERTURBED, "coil_stretch_m": 0.025},
        pick("stress_shift", "fatigue", "r_phase", "viscoelastic_creep", "gravity_load", "coil_slack"),
    )
    table["combination_thermal"] = (
        PERTURBED,
        pick("minor_loops", "latent_heat", "convection_nonlinearity", "ambient_drift", "thermocouple_lag", "thermocouple_heat_sink"),
    )
    table["combination_filters"] = (
        PERTURBED,
        pick("driver_lag", "duty_deadband", "junction", "thermocouple_two_lags", "thermocouple_heat_sink",
             "angle_sensor_second_order", "angle_sensor_drift"),
    )
    return table


# ---------------------------------------------------------------------------------------------------------------
# The schedule: breakpoints (time_s, duty), a line between them, sampled at 10 Hz and held; two breakpoints at one
# time are a step. It is zero for the first second, so the duty before the recording never matters.

SCHEDULE_A = [(0, 0), (1, 0), (1, 0.6), (7, 0.6), (8, 0.3), (8, 0), (20, 0), (20, 0.06), (22, 0.1), (22, 0.5),
              (24.5, 0.4), (24.5, 0), (46, 0), (46, 0.04), (52, 0.5), (54, 0.5), (57, 0)]
SCHEDULE_B = [(0, 0), (3, 0), (5, 0.08), (9, 0.08), (9, 0), (23, 0), (24, 0.6), (29, 0.6), (31, 0.3), (31, 0),
              (49, 0), (49, 0.35), (51.5, 0.45), (51.5, 0.05)]


def sample(breakpoints, t):
    value = breakpoints[0][1]
    for (t0, u0), (t1, u1) in zip(breakpoints, breakpoints[1:]):
        if t1 <= t:
            value = u1
        elif t0 <= t:
            value = u0 + (u1 - u0) * (t - t0) / (t1 - t0)
    return round(value, 4)


def schedule():
    return [(sample(SCHEDULE_A, k / 10), sample(SCHEDULE_B, k / 10)) for k in range(10 * DURATION + 1)]


# ---------------------------------------------------------------------------------------------------------------
# The equations

STATES = 27
(TA, TB, XA, XB, TH, OM, TBODY, MA, MB, TV, TM, NA, NB, SA, SB, JA, JB, LA, LB,
 UA, UB, FA, FB, GA, GB, TF, OF) = range(STATES)


def sigmoid_down(z):
    """1 / (1 + exp(z))"""
    return 1.0 / (1.0 + math.exp(z))


class Plant:
    def __init__(self, parameters, effects, fade=1e-6):
        p = dict(DEFAULTS)
        for name, value in parameters.items():
            assert name in p, name
            p[name] = value
        for name, values in effects.items():
            assert name in EFFECTS and set(values) == set(EFFECTS[name]), name
        self.p = p
        self.e = effects
        self.V_s = p["supply_voltage_V"]
        self.R = (p["resistance_A_Ohm"], p["resistance_B_Ohm"])
        self.C = (p["heat_capacity_A_J_K"], p["heat_capacity_B_J_K"])
        self.h = (p["heat_loss_A_W_K"], p["heat_loss_B_W_K"])
        self.r = (p["moment_arm_A_m"], p["moment_arm_B_m"])
        self.sign = p["bend_sign"]

        def value(effect, name, null):
            return effects[effect][name] if effect in effects else null

        self.tau_s = value("thermocouple_lag", "time_constant_s", 0.0)
        self.tau_1 = value("thermocouple_two_lags", "time_constant_s", 0.0)
        self.r_2 = value("thermocouple_two_lags", "second_share", 1.0)
        self.tau_u = value("driver_lag", "time_constant_s", 0.0)
        self.tau_f = value("angle_sensor_second_order", "time_s", 0.0)
        self.zeta = value("angle_sensor_second_order", "damping", 1.0)
        self.g = value("thermocouple_heat_sink", "gain", 1.0)
        self.G_b = value("body_heat_storage", "conductance_W_K", 0.0)
        self.C_b = value("body_heat_storage", "heat_capacity_J_K", 1.0)
        self.h_b = value("body_heat_storage", "heat_loss_W_K", 0.0)
        self.G_s = value("sheath_heat_storage", "conductance_W_K", 0.0)
        self.C_s = value("sheath_heat_storage", "heat_capacity_J_K", 1.0)
        self.h_s = value("sheath_heat_storage", "heat_loss_W_K", 0.0)
        self.C_x = value("junction", "heat_capacity_J_K", 0.0)
        self.G_x = value("junction", "conductance_W_K", 0.0)
        self.q_x = value("junction", "relative_power", 0.0)
        self.r_x = value("junction", "cooling_rate_1_s", 0.0)
        self.G_y = value("junction_layer", "conductance_W_K", 0.0)
        self.C_y = value("junction_layer", "heat_capacity_J_K", 1.0)
        self.h_y = value("junction_layer", "heat_loss_W_K", 0.0)
        assert self.C_x > 0 or self.G_y == 0, "a layer needs a junction"
        self.G_AB = value("cross_heating", "conductance_W_K", 0.0)
        self.L = value("latent_heat", "latent_heat_J", 0.0)
        self.beta = value("convection_nonlinearity", "slope_1_K", 0.0)
        self.alpha = value("airflow_change", "relative_change", 0.0)
        self.t_e = value("airflow_change", "onset_s", 0.0)
        self.s = value("ambient_drift", "rate_K_s", 0.0)
        self.rho = value("resistance_change", "relative_increase", 0.0)
        self.R_src = value("supply_sag", "source_resistance_Ohm", 0.0)
        self.u_0 = value("duty_deadband", "threshold_fraction", 0.0)
        self.d = value("input_delay", "delay_s", 0.0)
        self.shift = value("stress_shift", "shift_K_N", 0.0)
        self.curved_shift = value("stress_shift_curved", "shift_K_N", 0.0)
        self.g_0 = value("stress_shift_curved", "slope_slack", 1.0)
        self.g_1 = value("stress_shift_curved", "slope_taut", 1.0)
        self.heating_shift = value("stress_shift_two_slopes", "shift_K_N", 0.0)
        self.r_cool = value("stress_shift_two_slopes", "cooling_ratio", 1.0)
        self.kappa = value("fatigue", "loss_per_cycle", 0.0)
        self.mu = value("minor_loops", "slope_share", 0.0)
        self.f = value("r_phase", "share", 0.0)
        self.T_R = value("r_phase", "midpoint_degC", 45.0)
        self.w_R = value("r_phase", "width_K", 1.0)
        self.k_v = value("viscoelastic_creep", "stiffness_Nm_rad", 0.0)
        self.tau_v = value("viscoelastic_creep", "time_constant_s", 1.0)
        self.M_f = value("dry_friction", "moment_Nm", 0.0)
        self.om_s = value("dry_friction", "smoothing_rad_s", 1.0)
        self.k_3 = value("cubic_stiffening", "stiffness_Nm_rad3", 0.0)
        self.mgl = value("gravity_load", "moment_Nm", 0.0)
        self.phi = math.radians(value("gravity_load", "tilt_deg", 0.0))
        self.slack = value("coil_slack", "enabled", False)
        self.k_c = value("hard_stop", "stiffness_Nm_rad", 0.0)
        self.th_c = math.radians(value("hard_stop", "angle_deg", 0.0))
        self.tau_th = value("angle_sensor_lag", "time_constant_s", 0.0)
        self.c_th = value("angle_sensor_saturation", "saturation_1_rad2", 0.0)
        self.d_th = math.radians(value("angle_sensor_drift", "rate_deg_s", 0.0))
        self.fade = fade

    # CHOICE the drift is of T_∞ itself, so it reaches every place where T_∞ stands, the heat sink and the body too.
    def ambient(self, t):
        return self.p["ambient_temperature_degC"] + self.s * t

    def tension(self, j, T, xi, theta, n):
        p = self.p
        stretch = p["coil_stretch_m"] + (-1 if j == 0 else 1) * self.sign * self.r[j] * theta
        k = p["austenite_stiffness_N_m"] + xi * (p["martensite_stiffness_N_m"] - p["austenite_stiffness_N_m"])
        delta_t = p["transformation_stretch_m"] * (1 - self.kappa * n)
        # CHOICE r_phase: of the stretch δ_t, the share 1 - f follows ξ and the share f follows ξ_R(T), a sigmoid like
        # the envelopes'; stiffness stays k(ξ), T_R is not shifted by stress.
        share = xi
        if self.f != 0:
            share = (1 - self.f) * xi + self.f * sigmoid_down((T - self.T_R) / self.w_R)
        F = k * (stretch - share * delta_t)
        # CHOICE coil_slack replaces F wherever it stands, also in stress_shift.
        return max(0.0, F) if self.slack else F

    def curved_rise(self, x):
        """the integral of a slope that is straight between its corners, by trapezia"""
        corners = [(0.0, self.g_0), (0.5, 1.0), (1.0, self.g_1)]
        rise = self.g_0 * min(x, 0.0) + self.g_1 * max(x - 1.0, 0.0)
        for (a, at_a), (b, at_b) in zip(corners, corners[1:]):
            end = min(max(x, a), b)
            at_end = at_a + (at_b - at_a) * (end - a) / (b - a)
            rise += 0.5 * (at_a + at_end) * (end - a)
        return rise

    def envelopes(self, T, F):
        """upper, lower, and their slopes with temperature"""
        p = self.p
        F_0 = p["austenite_stiffness_N_m"] * p["coil_stretch_m"]
        dT = self.shift * F + self.curved_shift * F_0 * self.curved_rise(F / F_0)
        dT_heat, dT_cool = dT + self.heating_shift * F, dT + self.r_cool * self.heating_shift * F
        w_heat, w_cool = p["heating_width_K"], p["cooling_width_K"]
        heat = sigmoid_down((T - p["heating_midpoint_degC"] - dT_heat) / w_heat)
        cool = sigmoid_down((T - p["cooling_midpoint_degC"] - dT_cool) / w_cool)
        slope_heat = -heat * (1 - heat) / w_heat
        slope_cool = -cool * (1 - cool) / w_cool
        if cool > heat:
            heat = cool = 0.5 * (heat + cool)
        return heat, cool, slope_heat, slope_cool

    def elastic_moment(self, theta, F_A, F_B):
        """everything at ω = 0 and θ_v = θ"""
        M = self.sign * (self.r[0] * F_A - self.r[1] * F_B) - self.p["beam_stiffness_Nm_rad"] * theta
        M -= self.k_3 * theta**3
        M -= self.mgl * math.sin(theta + self.phi)
        beyond = abs(theta) - self.th_c
        if self.k_c != 0 and beyond > 0:
            M -= self.k_c * math.copysign(beyond, theta)
        return M

    def rates(self, t, y, u, windy):
        """u: the two duties after the delay; windy: whether t >= t_e (constant within a segment)"""
        T = (y[TA], y[TB])
        xi = (y[XA], y[XB])
        n = (y[NA], y[NB])
        theta, omega = y[TH], y[OM]
        T_inf = self.ambient(t)
        out = [0.0] * STATES

        # CHOICE order in the actuation: delay, lag, dead band, resistance, and the sag with the currents of all these.
        if self.tau_u != 0:
            out[UA], out[UB] = [(u[j] - y[UA + j]) / self.tau_u for j in (0, 1)]
            u = (y[UA], y[UB])
        v = [max(0.0, x - self.u_0) for x in u]
        R = [self.R[j] * (1 + self.rho * xi[j]) for j in (0, 1)]
        # CHOICE supply_sag: I = (u_A/R_A + u_B/R_B) V at the sagged V = V_s - R_src I, solved for V.
        V = self.V_s / (1 + self.R_src * (v[0] / R[0] + v[1] / R[1]))

        F = [self.tension(j, T[j], xi[j], theta, n[j]) for j in (0, 1)]
        for j in (0, 1):
            # CHOICE convection and airflow multiply; both change h_j of the wires only, not h_b of the body.
            h = self.h[j] * (1 + self.beta * (T[j] - T_inf))
            if windy:
                h *= 1 + self.alpha
            power = v[j] * V * V / R[j]
            heat_in = power - h * (T[j] - T_inf)
            followed = T[j]
            if self.C_x != 0:
                # CHOICE the share s of the power is the same in all coils, by the mean of C_j as they are in the file, and the
                # junction cools by r_x alone: convection and airflow leave it as it is.
                T_x, T_y = y[JA + j], y[LA + j]
                share_x = self.q_x * self.C_x / (sum(self.C) / len(self.C) + self.C_x)
                into_junction = share_x * power + self.G_x * (T[j] - T_x)
                into_layer = self.G_y * (T_x - T_y)
                heat_in -= into_junction
                out[JA + j] = (into_junction - self.r_x * self.C_x * (T_x - T_inf) - into_layer) / self.C_x
                out[LA + j] = (into_layer - self.h_y * (T_y - T_inf)) / self.C_y
                followed = T_x
            heat_in -= self.G_b * (T[j] - y[TBODY])
            into_sheath = self.G_s * (T[j] - y[SA + j])
            heat_in -= into_sheath
            heat_in -= self.G_AB * (T[j] - T[1 - j])
            out[SA + j] = (into_sheath - self.h_s * (y[SA + j] - T_inf)) / self.C_s

            upper, lower, slope_heat, slope_cool = self.envelopes(T[j], F[j])
            pull = max(0.0, lower - xi[j]) - max(0.0, xi[j] - upper)
            pull /= self.p["transformation_time_s"]
            # CHOICE minor_loops: strictly inside, dξ/dt = μ dξ_env/dT dT/dt, heating envelope if warming, cooling
            # envelope if cooling (the partial derivative: T alone moves it); outside only the pull. With latent heat
            # the two rates are solved together: C dT/dt = Q + L μ s dT/dt. As s < 0, dT/dt has the sign of Q.
            # The jump at the envelope is a sliding one (Filippov) where μ dξ_cool/dT is steeper than dξ_heat/dT:
            # there ξ moves with the envelope. That limit is reached by fading the share in over self.fade, a millionth
            # of ξ, inside the envelope; the remaining error is below 1e-4 degrees (README.md).
            share = 0.0
            if self.mu != 0 and lower < xi[j] < upper:
                slope = slope_heat if heat_in > 0 else slope_cool
                edge = min(xi[j] - lower, upper - xi[j])
                share = self.mu * slope * min(1.0, edge / self.fade)
            dT = (heat_in + self.L * pull) / (self.C[j] - self.L * share)
            dxi = pull + share * dT
            out[TA + j] = dT
            out[XA + j] = dxi
            out[NA + j] = abs(dxi) / 2
            if self.tau_s != 0:
                out[MA + j] = (followed - y[MA + j]) / self.tau_s
            if self.tau_1 != 0:
                out[FA + j] = (followed - y[FA + j]) / self.tau_1
                out[GA + j] = (y[FA + j] - y[GA + j]) / (self.r_2 * self.tau_1)
        out[TBODY] = (self.G_b * (T[0] - y[TBODY]) + self.G_b * (T[1] - y[TBODY]) - self.h_b * (y[TBODY] - T_inf)) / self.C_b

        M = self.elastic_moment(theta, F[0], F[1])
        M -= self.p["beam_damping_Nms_rad"] * omega
        M -= self.k_v * (theta - y[TV])
        if self.M_f != 0:
            M -= self.M_f * math.tanh(omega / self.om_s)
        out[TH] = omega
        out[OM] = M / self.p["beam_inertia_kgm2"]
        out[TV] = (theta - y[TV]) / self.tau_v
        if self.tau_th != 0:
            out[TM] = (theta - y[TM]) / self.tau_th
        if self.tau_f != 0:
            out[TF] = y[OF]
            out[OF] = (theta - y[TF] - 2 * self.zeta * self.tau_f * y[OF]) / self.tau_f**2
        return out

    def start(self):
        """cold and at rest: T = T_∞, ξ on the (shifted, and where they cross mean) cooling envelope, θ in balance"""
        T = self.p["ambient_temperature_degC"]

        def residual(z):
            theta, xi = z[0], z[1:]
            F = [self.tension(j, T, xi[j], theta, 0.0) for j in (0, 1)]
            cold = [self.envelopes(T, F[j])[1] for j in (0, 1)]
            return [self.elastic_moment(theta, *F) * 10, xi[0] - cold[0], xi[1] - cold[1]]

        z, info, flag, message = fsolve(residual, [0.0, 0.99, 0.99], xtol=1e-14, full_output=True)
        assert max(abs(r) for r in residual(z)) < 1e-12, message
        y = [0.0] * STATES
        y[FA] = y[FB] = y[GA] = y[GB] = T
        y[TF] = z[0]
        y[TA] = y[TB] = y[TBODY] = y[MA] = y[MB] = y[SA] = y[SB] = y[JA] = y[JB] = y[LA] = y[LB] = T
        y[TH] = y[TV] = y[TM] = z[0]
        y[XA], y[XB] = z[1], z[2]
        return y

    def reported(self, t, y):
        # CHOICE the junction first, whose bead is late, then the heat sink; the lag first, then the drift; the offset last.
        T_inf = self.ambient(t)
        body = (y[JA], y[JB]) if self.C_x != 0 else (y[TA], y[TB])
        bead = (y[MA], y[MB]) if self.tau_s != 0 else (y[GA], y[GB]) if self.tau_1 != 0 else body
        T = [T_inf + self.g * (x - T_inf) for x in bead]
        seen = y[TM] if self.tau_th != 0 else y[TF] if self.tau_f != 0 else y[TH]
        theta = seen / math.sqrt(1 + self.c_th * seen**2) + self.d_th * t
        return T[0], T[1], math.degrees(theta) + self.p["angle_offset_deg"]

    def simulate(self, duty, times, rtol=RTOL):
        """states at `times`; duty k holds from k/10 to (k+1)/10, before that it is 0"""
        breaks = {k / 10 + self.d for k in range(len(duty))} | {0.0, float(self.t_e)} | set(times)
        breaks = sorted(b for b in breaks if 0 <= b <= times[-1])
        starts = [k / 10 + self.d for k in range(len(duty))]
        tolerance = numpy.full(STATES, 1e-11)
        tolerance[[TA, TB, TBODY, MA, MB, SA, SB, JA, JB, LA, LB, FA, FB, GA, GB]] = 1e-9
        y = self.start()
        states = {0.0: list(y)}
        k = -1
        for t0, t1 in zip(breaks, breaks[1:]):
            while k + 1 < len(duty) and starts[k + 1] <= t0:
                k += 1
            u = duty[k] if k >= 0 else (0.0, 0.0)
            windy = t0 >= self.t_e
            run = solve_ivp(lambda t, x: self.rates(t, x.tolist(), u, windy), (t0, t1), y, method="DOP853",
                            rtol=rtol, atol=tolerance)
            assert run.success, run.message
            y = run.y[:, -1]
            states[t1] = y.tolist()
        return [states[t] for t in times]


# ---------------------------------------------------------------------------------------------------------------
# The files


def flow(value):
    """YAML flow form"""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{k}: {flow(v)}" for k, v in value.items()) + "}"
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value)


def write_duty(duty):
    with open(os.path.join(HERE, "duty.csv"), "w") as out:
        out.write("# /usr/bin/python3 tests/golden/reference.py\n# the duty of every case, held for 0.1 s\n")
        out.write("time_s,duty_A,duty_B,temperature_A_degC,temperature_B_degC,angle_deg\n")
        for k, (a, b) in enumerate(duty):
            out.write(f"{k / 10:.1f},{a:.4f},{b:.4f},,,\n")


def write_case(name, duty):
    parameters, effects = cases()[name]
    plant = Plant(parameters, effects)
    times = [k / 2 for k in range(2 * DURATION + 1)]
    states = plant.simulate(duty, times)
    with open(os.path.join(HERE, name + ".csv"), "w") as out:
        out.write(f"# /usr/bin/python3 tests/golden/reference.py {name}\n")
        out.write(f"# plant: {flow({'parameters': parameters, 'effects': effects})}\n")
        out.write("time_s,duty_A,duty_B,temperature_A_degC,temperature_B_degC,angle_deg\n")
        for i, (t, y) in enumerate(zip(times, states)):
            a, b = duty[5 * i]
            T_A, T_B, angle = plant.reported(t, y)
            out.write(f"{t:.1f},{a:.4f},{b:.4f},{T_A:.6f},{T_B:.6f},{angle + 0.0:.6f}\n")


def main(names):
    duty = schedule()
    write_duty(duty)
    for name in names or cases():
        write_case(name, duty)
        print(name, flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
