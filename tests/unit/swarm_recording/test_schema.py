"""Definitions of messages: each line counts, and a bag with another one is not played."""

import pytest

from swarm_common.model.errors import ConfigError
from swarm_recording.schema import check_definition, layout, schema_text

ODOMETRY = "nav_msgs/msg/Odometry"
LINES = schema_text(ODOMETRY).splitlines()
FIELDS = [
    number
    for number, line in enumerate(LINES)
    if (bare := line.partition("#")[0].strip())
    and not bare.startswith(("=", "MSG:"))
    and "=" not in bare
]


def changed(lines):
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    "name",
    [
        ODOMETRY,
        "sensor_msgs/msg/PointCloud2",
        "visualization_msgs/msg/MarkerArray",
        "diagnostic_msgs/msg/DiagnosticArray",
        "shape_msgs/msg/SolidPrimitive",
        "std_msgs/msg/Empty",
        "tf2_msgs/msg/TFMessage",
        "swarm_interfaces/msg/Beacon",
    ],
)
def test_the_installed_definition_fits(name):
    check_definition(schema_text(name), name)


def test_the_bytes_count_not_the_writing():
    text = "float64[36] covariance#c\n\n  Pose   pose # p\n"
    name = "geometry_msgs/msg/PoseWithCovariance"
    with pytest.raises(ConfigError, match="is not the installed one"):
        check_definition(text, name)
    check_definition("geometry_msgs/Pose pose\nfloat64[36] covariance", name)
    check_definition("uint8 KIND=3\nstring data 'x'", "std_msgs/msg/String")
    check_definition("byte data", "std_msgs/msg/UInt8")


@pytest.mark.parametrize("number", FIELDS)
def test_a_field_renamed_moved_doubled_or_gone_is_noticed(number):
    line = LINES[number]
    kind, _, rest = line.strip().partition(" ")
    variants = [
        [*LINES[:number], f"{kind} x{rest.strip()}", *LINES[number + 1 :]],
        [*LINES[:number], f"{kind}[] {rest.strip()}", *LINES[number + 1 :]],
        [*LINES[:number], line, line, *LINES[number + 1 :]],
        [*LINES[:number], *LINES[number + 1 :]],
        [*LINES[:number], f"{rest.strip()}?", *LINES[number + 1 :]],
    ]
    moved = [line, *LINES[:number], *LINES[number + 1 :]]
    if moved != LINES:
        first = [n for n in FIELDS if n < number]
        variants += [moved] if first else []
    for lines in variants:
        with pytest.raises(ConfigError):
            check_definition(changed(lines), ODOMETRY)


@pytest.mark.parametrize(
    "number", [number for number, line in enumerate(LINES) if line.startswith("MSG:")]
)
def test_a_section_renamed_or_doubled_is_noticed(number):
    end = next((n for n in range(number, len(LINES)) if LINES[n].startswith("=")), len(LINES))
    section = LINES[number - 1 : end]
    with pytest.raises(ConfigError):
        check_definition(changed([*LINES, *section]), ODOMETRY)
    renamed = [*LINES[:number], LINES[number] + "s", *LINES[number + 1 :]]
    with pytest.raises(ConfigError):
        check_definition(changed(renamed), ODOMETRY)
    headless = [*LINES[:number], "MSG", *LINES[number + 1 :]]
    with pytest.raises(ConfigError):
        check_definition(changed(headless), ODOMETRY)


@pytest.mark.parametrize("line", ["string", "int32 a b c", "int32 9a", "int32[x] a", "= 3", "@idl"])
def test_a_line_that_is_not_understood_is_an_error(line):
    with pytest.raises(ConfigError, match="line 2 of a message definition is not understood"):
        layout(f"bool a\n{line}\n", "a_msgs/msg/A")
