# SPDX-License-Identifier: Apache-2.0
"""Walks the graph of an ONNX model with NumPy: the operators that `sinew convert MODEL X.onnx` writes, each from its definition in ONNX's
Operators.md, with no word about our own layouts. Debian's ONNX 1.12 has no evaluator of its own."""
import numpy as np
import onnx
from onnx import numpy_helper


def lstm(x, w, r, b, lengths=None, h=None, c=None, *, hidden_size):
    """LSTM, version 7: X [steps, streams, inputs], gates stacked as i, o, f, c, B = [Wb, Rb]."""
    assert lengths is None
    streams = x.shape[1]
    h = np.zeros((streams, hidden_size), x.dtype) if h is None else h[0]
    c = np.zeros((streams, hidden_size), x.dtype) if c is None else c[0]
    wb, rb = np.split(b[0], 2)
    outputs = []
    for step in x:
        i, o, f, g = np.split(step @ w[0].T + h @ r[0].T + wb + rb, 4, axis=-1)
        i, o, f = (1 / (1 + np.exp(-z)) for z in (i, o, f))
        c = f * c + i * np.tanh(g)
        h = o * np.tanh(c)
        outputs.append(h[None])
    return np.stack(outputs), h[None], c[None]


def gemm(a, b, c, *, transA=0, transB=0):
    return (a.T if transA else a) @ (b.T if transB else b) + c


OPERATORS = {
    "Add": np.add, "Sub": np.subtract, "Mul": np.multiply, "Div": np.divide, "Relu": lambda x: np.maximum(x, 0), "Gemm": gemm,
    "Concat": lambda *parts, axis: np.concatenate(parts, axis), "Unsqueeze": lambda x, axes: np.expand_dims(x, tuple(axes)),
    "Squeeze": lambda x, axes: np.squeeze(x, tuple(axes)), "LSTM": lstm,
}


class Evaluator:
    def __init__(self, path):
        self.model = onnx.load(str(path))
        onnx.checker.check_model(self.model, full_check=True)
        self.constants = {one.name: numpy_helper.to_array(one) for one in self.model.graph.initializer}
        self.metadata = {one.key: one.value for one in self.model.metadata_props}
        self.inputs = {one.name: [d.dim_value or d.dim_param for d in one.type.tensor_type.shape.dim] for one in self.model.graph.input}
        self.outputs = [one.name for one in self.model.graph.output]

    def __call__(self, **inputs):
        assert set(inputs) == set(self.inputs), (set(inputs), set(self.inputs))
        values = {**self.constants, **{name: np.asarray(value, np.float32) for name, value in inputs.items()}}
        for node in self.model.graph.node:
            attributes = {a.name: onnx.helper.get_attribute_value(a) for a in node.attribute}
            results = OPERATORS[node.op_type](*(values[name] if name else None for name in node.input), **attributes)
            for name, result in zip(node.output, results if isinstance(results, tuple) else (results,)):
                if name:
                    values[name] = result
        assert all(values[name].dtype == np.float32 for name in self.outputs)
        return {name: values[name] for name in self.outputs}
