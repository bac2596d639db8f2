# SPDX-License-Identifier: Apache-2.0
"""`plant.parameters` and `plant.effects`: maps by the names of plant files, to read and to assign."""
import collections.abc
import json


def _plain(value):
    if isinstance(value, collections.abc.Mapping):
        return {key: _plain(one) for key, one in value.items()}
    return value if isinstance(value, (bool, str)) or value is None else float(value)


class Parameters(collections.abc.Mapping):
    """Name to `Parameter`, of the core and of the effects that are on. A number of the core can be assigned, in the parameter's unit; one
    outside its range is an InputError. Those of effects are assigned by `plant.effects`."""

    def __init__(self, plant):
        self._plant = plant

    def __getitem__(self, name):
        return self._plant._parameters()[name]

    def __setitem__(self, name, value):
        self._plant._change("parameters", json.dumps({name: _plain(value)}))

    def update(self, values):
        self._plant._change("parameters", json.dumps(_plain(values)))

    def __iter__(self):
        return iter(self._plant._parameters())

    def __len__(self):
        return len(self._plant._parameters())


class Effects(collections.abc.Mapping):
    """Name to `Effect`, all that there are. Assign a map of all its parameters to have an effect; delete it to have it no more."""

    def __init__(self, plant):
        self._plant = plant

    def __getitem__(self, name):
        return self._plant._effects()[name]

    def __setitem__(self, name, parameters):
        self._plant._change("effects", json.dumps({name: _plain(parameters)}))

    def __delitem__(self, name):
        self._plant._effects()[name]  # a KeyError where there is no such effect
        self._plant._change("effects", json.dumps({name: None}))

    def __iter__(self):
        return iter(self._plant._effects())

    def __len__(self):
        return len(self._plant._effects())
