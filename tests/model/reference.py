#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Reference values for tests/model/torch_test.cpp from PyTorch (Debian python3-torch): one small network of each kind, its
outputs over a stretch, the gradient of every weight, and the weights after one step of Adam.

    python3 tests/model/reference.py > tests/model/reference.json

All in 64-bit floats. The angle is fed back as Sinew does it: in stream 1 the own output from the second step on.
"""
import json
import torch

torch.manual_seed(20221106)
torch.set_default_dtype(torch.float64)
INPUTS, HIDDEN, DENSE, STEPS, STREAMS, RATE = 5, 6, 4, 7, 2, 0.01


def case(memoryless, output_relu):
    lstm = torch.nn.LSTMCell(INPUTS, HIDDEN)  # gates in the order input, forget, cell, output
    lstm.bias_hh.data.zero_()
    lstm.bias_hh.requires_grad_(False)
    dense, out = torch.nn.Linear(HIDDEN, DENSE), torch.nn.Linear(DENSE, 1)
    out.bias.data.fill_(0.3)
    exogenous = torch.rand(STEPS, STREAMS, INPUTS - 1)
    before = torch.rand(STEPS, STREAMS)
    target = torch.rand(STEPS, STREAMS)
    first = torch.zeros(2, STREAMS, HIDDEN) if memoryless else 0.5 * torch.randn(2, STREAMS, HIDDEN)
    first_output = torch.rand(STREAMS)
    free = torch.tensor([0.0, 1.0])
    h, c, y, outputs = first[0], first[1], first_output, []
    for t in range(STEPS):
        if memoryless:
            h, c = torch.zeros_like(h), torch.zeros_like(c)
        fed = free * y + (1 - free) * before[t]
        h, c = lstm(torch.cat([exogenous[t], fed[:, None]], 1), (h, c))
        y = out(torch.relu(dense(h)))[:, 0]
        if output_relu:
            y = torch.relu(y)
        outputs.append(y)
    outputs = torch.stack(outputs)
    loss = ((outputs - target) ** 2).mean()
    parameters = {"input": lstm.weight_ih, "recurrent": lstm.weight_hh, "bias": lstm.bias_ih, "dense": dense.weight,
                  "dense_bias": dense.bias, "output": out.weight, "output_bias": out.bias}
    weights = {n: p.detach().clone().tolist() for n, p in parameters.items()}
    adam = torch.optim.Adam(list(parameters.values()), lr=RATE, eps=1e-8)
    loss.backward()
    gradient = {n: p.grad.tolist() for n, p in parameters.items()}
    adam.step()
    return {"memoryless": memoryless, "output_relu": output_relu, "inputs": INPUTS, "hidden": HIDDEN, "dense": DENSE,
            "steps": STEPS, "streams": STREAMS, "weights": weights, "exogenous": exogenous.tolist(), "before": before.tolist(),
            "target": target.tolist(), "h": first[0].tolist(), "c": first[1].tolist(), "last_output": first_output.tolist(),
            "outputs": outputs.tolist(), "loss": loss.item(), "gradient": gradient, "rate": RATE,
            "after_adam": {n: p.detach().tolist() for n, p in parameters.items()}}


print(json.dumps([case(False, False), case(False, True), case(True, True)], indent=0))
