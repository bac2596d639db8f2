#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The same equations in plain Python with SciPy's solvers, on the same duty: how many times longer than Sinew's?

    against_scipy.py FOLDER      FOLDER: what `bench_simulate --export FOLDER` wrote

Each solver is started again wherever the duty changes, as it must be. The right-hand side computes with plain floats
(faster here than arrays of two), the Jacobian is analytic, and the first step is given where a trial says that it helps.
Every solver runs the ten minutes at tolerances from loose to tight, until it is more exact than Sinew at 1e-6. Of those at
which its angle is no more exact than Sinew's the most exact counts, or the loosest where all are more exact; then the
quickest solver.
`solve_ivp` is SciPy's present interface, and what the goal is about; `odeint`, its old one, steps inside compiled code and
calls Python for the right-hand side alone. It is shown too, being the quickest that SciPy has.
All times are processor time of one thread, Sinew's too.
"""
import json
import math
import os
import pathlib
import sys
import time
import warnings

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # matrices are 6 x 6
import numpy as np
from scipy.integrate import odeint, solve_ivp

CHECK_S = 60.0
TRIAL_S = 30.0
GOAL = 30.0
TOLERANCES = [10.0 ** (-e / 2) for e in range(6, 17)]  # 1e-3 ... 1e-8
WHOLE_DECADES = {"BDF", "Radau"}  # these take long

folder = pathlib.Path(sys.argv[1])
sinew = json.loads((folder / "simulate.json").read_text())
duty = np.loadtxt(folder / "duty.csv", delimiter=",", skiprows=1)
reference = np.loadtxt(folder / "reference.csv", delimiter=",", skiprows=1)
scales = np.array(sinew["scales"])
first_state = np.array(sinew["first_state"])
DEGREES = 180.0 / math.pi


def make_equations(p):
    """rates(t, y) and jacobian(t, y) for a held duty: plant.md, section 1, with everything that is constant taken out."""
    exp = math.exp
    C_A, C_B = p["heat_capacity_A_J_K"], p["heat_capacity_B_J_K"]
    cool_A, cool_B = p["heat_loss_A_W_K"] / C_A, p["heat_loss_B_W_K"] / C_B
    heat_A = p["supply_voltage_V"] ** 2 / p["resistance_A_Ohm"] / C_A
    heat_B = p["supply_voltage_V"] ** 2 / p["resistance_B_Ohm"] / C_B
    ambient = p["ambient_temperature_degC"]
    T_h, w_h = p["heating_midpoint_degC"], p["heating_width_K"]
    T_c, w_c = p["cooling_midpoint_degC"], p["cooling_width_K"]
    tau = p["transformation_time_s"]
    k_a, dk = p["austenite_stiffness_N_m"], p["martensite_stiffness_N_m"] - p["austenite_stiffness_N_m"]
    d_0, d_t = p["coil_stretch_m"], p["transformation_stretch_m"]
    sign = p["bend_sign"]
    a, b = sign * p["moment_arm_A_m"], sign * p["moment_arm_B_m"]
    k_b, c, J = p["beam_stiffness_Nm_rad"], p["beam_damping_Nms_rad"], p["beam_inertia_kgm2"]

    def pull(T, x):
        heating = 1.0 / (1.0 + exp((T - T_h) / w_h))
        cooling = 1.0 / (1.0 + exp((T - T_c) / w_c))
        if cooling > heating:
            heating = cooling = 0.5 * (heating + cooling)
        if x < cooling:
            return (cooling - x) / tau
        if x > heating:
            return (heating - x) / tau
        return 0.0

    def hold(u_A, u_B):
        q_A = u_A * heat_A + cool_A * ambient
        q_B = u_B * heat_B + cool_B * ambient

        def rates(t, y):
            T_A, T_B, x_A, x_B, angle, omega = y.tolist()
            moment = (a * (k_a + x_A * dk) * (d_0 - a * angle - x_A * d_t)
                      - b * (k_a + x_B * dk) * (d_0 + b * angle - x_B * d_t))
            return (q_A - cool_A * T_A, q_B - cool_B * T_B, pull(T_A, x_A), pull(T_B, x_B), omega,
                    (moment - c * omega - k_b * angle) / J)

        return rates

    def pull_slopes(T, x):
        """d pull / dT and d pull / dx."""
        heating = 1.0 / (1.0 + exp((T - T_h) / w_h))
        cooling = 1.0 / (1.0 + exp((T - T_c) / w_c))
        heating_slope = -heating * (1.0 - heating) / w_h
        cooling_slope = -cooling * (1.0 - cooling) / w_c
        if cooling > heating:
            heating = cooling = 0.5 * (heating + cooling)
            heating_slope = cooling_slope = 0.5 * (heating_slope + cooling_slope)
        if x < cooling:
            return cooling_slope / tau, -1.0 / tau
        if x > heating:
            return heating_slope / tau, -1.0 / tau
        return 0.0, 0.0

    def jacobian(t, y):
        T_A, T_B, x_A, x_B, angle, omega = y.tolist()
        A_T, A_x = pull_slopes(T_A, x_A)
        B_T, B_x = pull_slopes(T_B, x_B)
        k_A, k_B = k_a + x_A * dk, k_a + x_B * dk
        by_x_A = a * (dk * (d_0 - a * angle - x_A * d_t) - k_A * d_t)
        by_x_B = -b * (dk * (d_0 + b * angle - x_B * d_t) - k_B * d_t)
        by_angle = -a * a * k_A - b * b * k_B - k_b
        return np.array(((-cool_A, 0.0, 0.0, 0.0, 0.0, 0.0), (0.0, -cool_B, 0.0, 0.0, 0.0, 0.0),
                         (A_T, 0.0, A_x, 0.0, 0.0, 0.0), (0.0, B_T, 0.0, B_x, 0.0, 0.0),
                         (0.0, 0.0, 0.0, 0.0, 0.0, 1.0),
                         (0.0, 0.0, by_x_A / J, by_x_B / J, by_angle / J, -c / J)))

    return hold, jacobian


hold, jacobian = make_equations(sinew["parameters"])


def segments(until_s):
    """(u_A, u_B, times of the samples from the segment's start to its end) for each stretch of unchanged duty."""
    count = int(np.searchsorted(duty[:, 0], until_s + 1e-9))
    changes = [0] + [k for k in range(1, count) if (duty[k, 1:] != duty[k - 1, 1:]).any()]
    ends = changes[1:] + [count - 1]
    return [(*duty[k, 1:].tolist(), duty[k:end + 1, 0]) for k, end in zip(changes, ends) if end > k]


def with_solve_ivp(method, rtol, first_step):
    options = {} if method in ("RK45", "RK23", "DOP853") else {"jac": jacobian}
    if first_step:
        options["first_step"] = first_step

    def advance(u_A, u_B, times, y):
        inner = times[1:] if len(times) > 2 else None  # one step of the samples needs no interpolation
        run = solve_ivp(hold(u_A, u_B), (times[0], times[-1]), y, method=method, rtol=rtol, atol=rtol * scales,
                        t_eval=inner, **options)
        if not run.success:
            raise RuntimeError(run.message)
        return run.y.T if inner is not None else run.y[:, -1:].T

    return advance


def with_odeint(rtol, first_step):
    def advance(u_A, u_B, times, y):
        # h0 = 0: LSODA chooses. Differences for its Jacobian are cheaper here than calling ours.
        return odeint(hold(u_A, u_B), y, times, rtol=rtol, atol=rtol * scales, h0=first_step or 0.0, tfirst=True,
                      mxstep=100000)[1:]

    return advance


def run(advance, until_s):
    """Angles at the samples [deg], temperatures, and processor time [s]."""
    parts = segments(until_s)
    began = time.thread_time()
    y = first_state
    states = [y]
    for u_A, u_B, times in parts:
        rows = advance(u_A, u_B, times, y)
        states.extend(rows)
        y = rows[-1]
    spent = time.thread_time() - began
    return np.array(states), spent


def errors(states):
    angle = states[:, 4] * DEGREES + sinew["parameters"]["angle_offset_deg"] - reference[:len(states), 3]
    kelvin = states[:, :2] - reference[:len(states), 1:3]
    return math.sqrt(np.mean(angle ** 2)), math.sqrt(np.mean(kelvin ** 2))


def solver(name, rtol, first_step):
    return with_odeint(rtol, first_step) if name == "odeint" else with_solve_ivp(name, rtol, first_step)


def main():
    warnings.simplefilter("ignore")
    check, _ = run(solver("odeint", 1e-11, None), CHECK_S)
    angle_deg, kelvin = errors(check)
    agrees = angle_deg < 1e-6 and kelvin < 1e-6
    print(f"Same equations: SciPy's LSODA at 1e-11 and Sinew's CVODE at 1e-12 differ by {angle_deg:.1e} deg and "
          f"{kelvin:.1e} K (rms, {CHECK_S:.0f} s): {'they agree' if agrees else '**they do not: the comparison is void**'}.\n")
    if not agrees:
        return 1

    most_exact = min(method["angle_rms_deg"] for method in sinew["methods"])
    first_steps, scans = {}, {}
    print("| SciPy solver | first step | relative tolerance: angle error rms [deg], s |\n|---|---|---|")
    for name in ["LSODA", "BDF", "Radau", "RK45", "odeint"]:
        trials = [(run(solver(name, 1e-5, h), TRIAL_S)[1], h) for h in (None, 1e-3)]
        first_steps[name] = min(trials, key=lambda trial: trial[0])[1]
        scans[name] = []
        for rtol in TOLERANCES[::2] if name in WHOLE_DECADES else TOLERANCES:
            states, spent = run(solver(name, rtol, first_steps[name]), math.inf)
            scans[name].append((rtol, errors(states)[0], spent))
            if scans[name][-1][1] < most_exact:
                break
        step = f"{first_steps[name]:g} s" if first_steps[name] else "its own"
        print(f"| {name} | {step} | " + "; ".join(f"{r:.1e}: {e:.1e}, {s:.2f}" for r, e, s in scans[name]) + " |")

    print("\n| Sinew at 1e-6 | its angle error rms [deg] | ms | SciPy | its relative tolerance | its angle error rms [deg] | ms "
          "| ratio | goal | |\n|---|---|---|---|---|---|---|---|---|---|")
    for method in sinew["methods"]:
        for names in (["LSODA", "BDF", "Radau", "RK45"], ["odeint"]):
            chosen = []
            for name in names:
                no_more_exact = [entry for entry in scans[name] if entry[1] >= method["angle_rms_deg"]]
                chosen.append((*(min(no_more_exact, key=lambda entry: entry[1]) if no_more_exact else scans[name][0]), name))
            rtol, error, spent, name = min(chosen, key=lambda entry: entry[2])
            for _ in range(2):
                spent = min(spent, run(solver(name, rtol, first_steps[name]), math.inf)[1])
            ratio = spent / method["time_s"]
            goal = "none |"
            if name != "odeint":
                goal = f"at least {GOAL:.0f} | {'reached' if ratio >= GOAL else '**missed**'}"
            print(f"| {method['name']} | {method['angle_rms_deg']:.1e} | {1e3 * method['time_s']:.1f} "
                  f"| {name if name == 'odeint' else 'solve_ivp, ' + name} | {rtol:.1e} | {error:.1e} | {1e3 * spent:.0f} "
                  f"| {ratio:.0f} | {goal} |")
    print(f"\nLeast of 3 runs of what counts; load {os.getloadavg()[0]:.2f} of {os.cpu_count()} cores.")
    return 0


sys.exit(main())
