"""What laglab refuses, and why."""

from __future__ import annotations


class LaglabError(Exception):
    """A sentence of laglab, such as `duration_s: must be 0.01 to 3600 s; got -5`.

    `status` is the HTTP status of a daemon, None of a program on this machine. `fields` has the refused fields
    with a sentence for each, as far as they are known. `retry_after_s` says when a request can be made again.
    """

    def __init__(
        self,
        sentence: str,
        *,
        status: int | None = None,
        fields: dict[str, str] | None = None,
        retry_after_s: float | None = None,
    ) -> None:
        super().__init__(sentence)
        self.status = status
        self.fields = fields or {}
        self.retry_after_s = retry_after_s
