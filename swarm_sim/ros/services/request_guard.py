"""End of a request to `/sim`: whatever goes wrong with it becomes its answer."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from simulation_interfaces.msg import Result

from swarm_common.middleware.rejections import Rejections
from swarm_common.process.standard_streams import FaultLog
from swarm_sim.world.request_checks import Reason, RefusedError, check_request

Codes = Mapping[Reason, int]
RESULTS: Codes = {
    Reason.UNKNOWN: Result.RESULT_NOT_FOUND,
    Reason.UNSUPPORTED: Result.RESULT_FEATURE_UNSUPPORTED,
}


class Door:
    """Lets requests in that `check_request` admits, and fills in their results."""

    def __init__(self, rejections: Rejections) -> None:
        self._rejections = rejections
        self._faults = FaultLog("request")

    def attempt(self, response: Any, codes: Codes, do: Callable[[], None]) -> bool:
        """Execute a request; whatever goes wrong becomes the answer. Return whether it was done.

        Args:
            response: The field `result` is filled in.
            codes: Result codes of this service by reason; OPERATION_FAILED for all others.
        """
        try:
            do()
        except RefusedError as error:
            response.result.result = codes.get(error.reason, Result.RESULT_OPERATION_FAILED)
            response.result.error_message = str(error)
            return False
        except Exception as error:  # a fault of ours: it must not end the world
            response.result.result = Result.RESULT_OPERATION_FAILED
            response.result.error_message = self._faults.note(error)
            self._rejections.reject("/sim", "a client", response.result.error_message)
            return False
        response.result.result = Result.RESULT_OK
        return True

    def admit(self, request: Any, handle: Callable[[Any], None]) -> None:
        """Go on with a request that passes the door.

        Raises:
            RefusedError: If it does not pass, or `handle` refuses it.
        """
        try:
            check_request(request)
        except RefusedError as error:
            self._rejections.reject("/sim", "a client", error)
            raise
        handle(request)
