#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The same batches by PyTorch (Debian python3-torch): that the same numbers come out, and how long they take.

    bench_network --export FOLDER; bench/against_torch.py FOLDER

PyTorch has as many threads as bench_network. Its stateful update goes through torch.nn.LSTMCell step by step, since the output
is fed back; its published one through torch.nn.LSTM, a window of one. Both with torch.optim.Adam.
"""
import json
import pathlib
import sys
import time

import h5py
import numpy as np
import torch

folder = pathlib.Path(sys.argv[1])
ours = json.loads((folder / "network.json").read_text())
torch.set_num_threads(ours["threads"])
file = h5py.File(folder / "batch.h5")


def tensor(group, name):
    return torch.tensor(np.array(file[group][name]), dtype=torch.float32)


def fastest_s(work, times):
    least = 1e9
    for _ in range(times):
        began = time.perf_counter()
        work()
        least = min(least, time.perf_counter() - began)
    return least


def network(group, cell):
    lstm = (torch.nn.LSTMCell if cell else torch.nn.LSTM)(5, 300)
    names = dict(lstm.named_parameters())
    end = "" if cell else "_l0"
    with torch.no_grad():
        names["weight_ih" + end].copy_(tensor(group, "input"))
        names["weight_hh" + end].copy_(tensor(group, "recurrent"))
        names["bias_ih" + end].copy_(tensor(group, "bias")[:, 0])
        names["bias_hh" + end].zero_()
        dense, out = torch.nn.Linear(300, 300), torch.nn.Linear(300, 1)
        dense.weight.copy_(tensor(group, "dense"))
        out.weight.copy_(tensor(group, "output"))
        dense.bias.zero_()
        out.bias.zero_()
    names["bias_hh" + end].requires_grad_(False)
    return lstm, dense, out, end


def stateful():
    lstm, dense, out, _ = network("stateful", True)
    exogenous, target = tensor("stateful", "exogenous"), tensor("stateful", "target")  # [4 x T B], [B x T]
    streams, steps = target.shape
    x = exogenous.T.reshape(steps, streams, 4).contiguous()

    def loss():
        h = c = torch.zeros(streams, 300)
        y, outputs = torch.full((streams,), 0.5), []
        for t in range(steps):
            h, c = lstm(torch.cat([x[t], y[:, None]], 1), (h, c))
            y = out(torch.relu(dense(h)))[:, 0]
            outputs.append(y)
        outputs = torch.stack(outputs, 1)
        return ((outputs - target) ** 2).mean(), outputs

    return loss, lstm, dense, out, ""


def published():
    lstm, dense, out, end = network("published", False)
    x = torch.cat([tensor("published", "exogenous"), tensor("published", "angle_before").T], 0).T.reshape(1, -1, 5).contiguous()
    target = tensor("published", "target")

    def loss():
        outputs = torch.relu(out(torch.relu(dense(lstm(x)[0]))))[0]
        return ((outputs - target) ** 2).mean(), outputs

    return loss, lstm, dense, out, end


print("| one update | Sinew, ms | PyTorch, ms | PyTorch over Sinew | goal | | largest difference of outputs | of gradients, relative |")
print("|---|---|---|---|---|---|---|---|")
for name, made, times in (("published", published(), 200), ("stateful", stateful(), 8)):
    loss, lstm, dense, out, end = made
    parameters = [p for layer in (lstm, dense, out) for p in layer.parameters() if p.requires_grad]
    adam = torch.optim.Adam(parameters, lr=1e-3)
    value, outputs = loss()
    value.backward()
    off = (outputs.detach() - tensor(name, "outputs")).abs().max().item()
    weights = dict(lstm.named_parameters())
    off_gradient = max(((p.grad - tensor(name, "gradient_" + n)).norm() / p.grad.norm()).item() for p, n in
                       ((weights["weight_ih" + end], "input"), (dense.weight, "dense")))

    def update():
        adam.zero_grad()
        value, _ = loss()
        value.backward()
        adam.step()

    update()
    theirs, mine = fastest_s(update, times), ours[name + "_update_s"]
    verdict = "reached" if theirs >= 3.0 * mine else "**missed**"
    print(f"| {name} | {1e3 * mine:.2f} | {1e3 * theirs:.2f} | {theirs / mine:.2f} | at least 3 | {verdict} "
          f"| {off:.1e} | {off_gradient:.1e} |")

lstm, dense, out, _ = network("stateful", True)
torch.set_num_threads(1)
with torch.no_grad():
    x, h, c = torch.rand(1, 5), torch.zeros(1, 300), torch.zeros(1, 300)

    def step():
        a, b = lstm(x, (h, c))
        out(torch.relu(dense(a)))

    step()
    theirs, mine = fastest_s(step, 3000), ours["stateful_step_s"]
verdict = "reached" if theirs >= 5 * mine else "**missed**"
print("\n| one step of prediction | Sinew, us | PyTorch, us | PyTorch over Sinew | goal | |\n|---|---|---|---|---|---|")
print(f"| stateful, 300 and 300 | {1e6 * mine:.1f} | {1e6 * theirs:.1f} | {theirs / mine:.1f} | at least 5 | {verdict} |")
