"""Parameters of localisation: AMCL's where AMCL has them, and what a lost robot is."""

from __future__ import annotations

from dataclasses import dataclass

from swarm_common.model.errors import ConfigError
from swarm_nav.core.limits import ParameterGroup, check

AMCL = "amcl"  # the type that finds the pose itself
START_DEVIATION = (0.05, 0.05)  # [m] and [rad] of a pose that the operator gave


@dataclass(frozen=True, slots=True, kw_only=True)
class LocalisationConfig(ParameterGroup):
    """Localisation; `localisation.` parameters, all but `type` for amcl, named as Nav2's."""

    group = "localisation"
    type: str = "odometry"  # how the robot knows where it is: odometry | amcl
    alpha1: float = 0.0002  # variance of a turn [rad²] per rad² turned
    alpha2: float = 0.0004  # [rad²/m²] variance of a turn per m² driven
    alpha3: float = 0.0016  # variance of a distance [m²] per m² driven
    alpha4: float = 0.0001  # [m²/rad²] variance of a distance per rad² turned
    alpha5: float = 0.0025  # variance sideways per m² driven, of omnidirectional drives
    yaw_drift: float = 0.001  # [rad/s] of the heading while the robot moves
    update_min_d: float = 0.25  # [m] driven after which a scan is compared with the map
    update_min_a: float = 0.2  # [rad] turned after which a scan is compared with the map
    update_period: float = 5.0  # [s] of motion after which a scan is compared with the map
    min_particles: int = 200  # particles, at least
    max_particles: int = 1000  # particles, at most
    pf_err: float = 0.05  # largest error of the particles' distribution (KLD sampling)
    pf_z: float = 0.99  # probability of keeping within it
    max_beams: int = 60  # rays of a scan that are compared
    sigma_hit: float = 0.1  # [m] spread of hits about a mapped wall
    z_hit: float = 0.5  # weight of hits on mapped walls
    z_rand: float = 0.5  # weight of all other hits
    laser_likelihood_max_dist: float = 0.5  # [m] beyond which the distance does not count
    do_beamskip: bool = True  # leave out hits that few particles agree with
    beam_skip_distance: float = 0.3  # [m] from a wall within which a particle agrees with a hit
    beam_skip_threshold: float = 0.3  # share of the particles that must agree, or the hit is left
    beam_skip_error_threshold: float = 0.9  # share of hits left out from which all count again
    recovery_alpha_slow: float = 0.001  # rate of the slow mean of how well scans fit the map
    recovery_alpha_fast: float = 0.3  # rate of the fast mean; their ratio decides on new particles
    recovery_spread: float = 0.4  # [m] standard deviation of new particles around the estimate
    recovery_spread_yaw: float = 0.3  # [rad] standard deviation of their heading
    lost_fit: float = 0.6  # share of hits on mapped walls below which the robot is lost
    lost_deviation: float = 0.45  # [m] (standard) of the position above which the robot is lost
    most_margin: float = 0.4  # [m] of safety margin that a robot announces at most
    tracking_margin: float = 0.03  # [m] of the safety margin that is not for localisation
    margin_per_sigma: float = 2.0  # standard deviations of the position for which there is room
    random_seed: int = 0  # together with the robot's id

    def __post_init__(self) -> None:
        check(self)
        if self.min_particles > self.max_particles:
            raise ConfigError(
                f"localisation.min_particles is {self.min_particles} and max_particles is"
                f" {self.max_particles}; expected them in this order"
            )
