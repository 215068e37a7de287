"""What can go wrong, one class for each cause."""


class SquirmError(Exception):
    """Base of all errors of this package."""


class NotASnapshot(SquirmError, ValueError):
    """Bytes that are no snapshot message of a known version, or whose header is damaged."""


class NotARecording(SquirmError, ValueError):
    """A file that is no MCAP file, or no recording of squirm."""


class DamagedRecording(SquirmError, ValueError):
    """A recording whose checksums do not match, or that contradicts itself. Nothing damaged is returned."""


class NoSuchRun(SquirmError, LookupError):
    """There is no recording at this place, or no run of this name is live."""


class NoSuchTopic(SquirmError, LookupError):
    """The run did not record, or does not publish, this topic."""


class NoSuchColumn(SquirmError, AttributeError, KeyError):
    """The snapshot has no column of this name."""

    def __str__(self) -> str:
        return str(self.args[0]) if self.args else ""


class TooManyHeld(SquirmError, RuntimeError):
    """More live snapshots are held than shared memory has room for; keep copies instead."""


class LiveError(SquirmError, RuntimeError):
    """Shared memory refused something; the message says what."""


class RecordingWarning(UserWarning):
    """Something about a recording that its reader should know, such as an end that was cut off."""
