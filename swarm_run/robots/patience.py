"""How long a command waits for a swarm that it does not see yet."""

from __future__ import annotations

from collections.abc import Callable

from swarm_common.model.errors import ConfigError, NoSwarmError

LOOK_LIMIT = 5.0  # [s] of wall time to see a swarm of which nothing is known
START_LIMIT = 300.0  # [s] of wall time for a swarm that starts; its code may be compiled first
TELL_AFTER = 3.0  # [s] of waiting in silence


class SwarmPatience:
    """Waits for a swarm that is not seen yet while one starts, and no longer."""

    def __init__(
        self,
        domain: int,
        has_swarm: Callable[[], bool | None],
        tell: Callable[[str], None],
        limit: float = LOOK_LIMIT,
    ) -> None:
        """Begin with nothing said.

        Args:
            has_swarm: Says whether somebody has it; None if that cannot be known.
            limit: [s] of wall time where it cannot be known.
        """
        self._domain, self._has_swarm, self._tell, self._limit = domain, has_swarm, tell, limit
        self._is_told = False

    def check(self, waited: float) -> None:
        """Say once what is waited for.

        Args:
            waited: [s] of wall time so far.

        Raises:
            NoSwarmError: If there is no swarm to wait for.
            ConfigError: If one starts that does not come up.
        """
        known = self._has_swarm()
        if known is False or (known is None and waited > self._limit):
            raise NoSwarmError(self._domain)
        if waited > START_LIMIT:
            raise ConfigError(
                f"the swarm in ROS domain {self._domain} has not come up within"
                f" {START_LIMIT:.0f} s; see what its swarm-up says"
            )
        if known and waited > TELL_AFTER and not self._is_told:
            self._tell(f"the swarm in ROS domain {self._domain} is starting; waiting for it")
            self._is_told = True
