# SPDX-License-Identifier: Apache-2.0
"""What the module raises, in the words of the commands."""


class InputError(ValueError):
    """A file, a value in it or an argument is wrong. The message is the one that the command prints; its parts are attributes."""

    def __init__(self, message, file="", line=0, column=0, key="", value="", advice=""):
        super().__init__(message)
        self.file, self.line, self.column = file, line, column
        self.key, self.value, self.advice = key, value, advice

    def __reduce__(self):
        return InputError, (self.args[0], self.file, self.line, self.column, self.key, self.value, self.advice)


class IntegrationError(RuntimeError):
    """The plant could not be integrated; the message says when, and what the solver said."""
