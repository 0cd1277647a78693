"""Drive, wheels, limits and LiDAR of robots after the habits of public descriptions."""

import re

import numpy as np
import pytest
import trimesh

from swarm_common.model.errors import RobotModelError, SwarmError
from swarm_describe.robots.drive_tags import is_omni, is_passive, words
from swarm_describe.robots.loading import account_of, load_robot, open_robot
from tests.fakes.foreign_robots import (
    ACCELERATIONS,
    CONTROL,
    CORNERS,
    DIFFERENTIAL,
    FOREIGN,
    SDF,
    Folder,
    fast_wheels,
    four_wheels,
    hub_first,
    inboard_tyres,
    limits_by_controller,
    made_wheel,
    mecanum_by_controller,
    on_rollers,
    plugin_drive,
    rear_first,
    solid,
    two_wheels,
)
from tests.fakes.own_robots import (
    LIMITS,
    Own,
    cylinder,
    inertial,
    joint,
    lidar,
    link,
    pair,
    robot,
    wheel,
)

JOINTS = "<left_joint>left_wheel_joint</left_joint><right_joint>right_wheel_joint</right_joint>{}"


def plugin(file, inside="", name="drive"):
    return f'<gazebo><plugin filename="{file}" name="{name}">{inside}</plugin></gazebo>'


def notes_of(own, folder):
    return "\n".join(open_robot(own.write(folder)).model.notes)


@pytest.mark.parametrize("kind", FOREIGN)
def test_they_load(kind, tmp_path):
    spec = load_robot(FOREIGN[kind]().write(tmp_path))
    assert len(spec.wheels_left) == len(spec.wheels_right) >= 1


def test_names_are_split_into_words():
    assert words("Front_leftCasterWheel2-jointABc") == (
        "front", "left", "caster", "wheel", "joint", "a", "bc",
    )  # fmt: skip
    for name in ("controller_left_wheel", "omnicorp", "freebot_wheel", "broadcaster"):
        assert not is_omni(name), name
        assert not is_passive(name), name
    for name in ("mecanumWheelFL", "omni_wheel_1", "base-omni", "roller_3"):
        assert is_omni(name), name
    for name in ("rear_castor", "CasterWheel", "free_wheel", "idler2"):
        assert is_passive(name), name


@pytest.mark.parametrize("name", ["omnicorp_two_wheeler", "controller_bot", "omni_bot", "mecanum"])
def test_two_wheels_are_differential_whatever_the_robot_is_called(name, tmp_path):
    assert load_robot(two_wheels(*pair(), name=name).write(tmp_path)).drive == "differential"


@pytest.mark.parametrize("word", ["freebot", "free", "caster"])
def test_a_word_that_all_wheels_share_makes_none_a_caster(word, tmp_path):
    wheels = [wheel(f"{word}_{s}", (0, y, 0.05)) for s, y in (("left", 0.15), ("right", -0.15))]
    assert load_robot(two_wheels(*wheels).write(tmp_path)).drive == "differential"


@pytest.mark.parametrize(
    ("name", "places", "drive"),
    [
        ("controller_4", CORNERS, "skid"),
        ("mecanum_4", CORNERS, "omni"),
        ("plain", [(f"mecanum_{name}", x, y) for name, x, y in CORNERS], "omni"),
        ("plain", [(f"omnicorp_{name}", x, y) for name, x, y in CORNERS], "skid"),
    ],
)
def test_names_count_last(name, places, drive, tmp_path):
    wheels = [wheel(place, (x, y, 0.05)) for place, x, y in places]
    body = link("base_link", '<box size="0.4 0.26 0.1"/>', inertial(6.0, 0.08), xyz="0 0 0.1")
    own = Own(robot(name, [body, *wheels, lidar(xyz=(0.1, 0.0, 0.2))]))
    assert load_robot(own.write(tmp_path)).drive == drive
    assert f"drive is {drive} (guessed: 4 wheels" in notes_of(own, tmp_path)
    stated = plugin("libgazebo_ros_skid_steer_drive.so")
    own = Own(robot(name, [body, *wheels, stated, lidar(xyz=(0.1, 0.0, 0.2))]))
    assert load_robot(own.write(tmp_path)).drive == "skid"
    assert "guessed" not in notes_of(own, tmp_path)


def test_rollers_make_a_drive_omnidirectional(tmp_path):
    assert load_robot(on_rollers().write(tmp_path)).drive == "omni"


def test_three_wheels_in_a_star_are_omnidirectional(tmp_path):
    body = link("base_link", cylinder(0.2, 0.1), inertial(9.0, 0.2), xyz="0 0 0.13")
    wheels = []
    for k, (x, y) in enumerate(((0.16, 0.0), (-0.08, 0.13856), (-0.08, -0.13856))):
        angle = float(np.arctan2(y, x))
        wheels += [
            link(f"w{k}", cylinder(0.06, 0.03), inertial(0.4, 1e-3), rpy="0 1.5707963 0"),
            joint(f"w{k}_joint", "base_link", f"w{k}", (x, y, 0.06), f"0 0 {angle}",
                  "continuous", "1 0 0"),
        ]  # fmt: skip
    own = Own(robot("star", [body, *wheels, lidar(xyz=(0.1, 0.0, 0.25))]))
    spec = load_robot(own.write(tmp_path))
    assert (spec.drive, spec.wheels_left) == ("omni", ())


@pytest.mark.parametrize(
    ("file", "name", "drive"),
    [
        ("libgazebo_ros_diff_drive.so", "omni_mecanum_drive", "differential"),
        ("libgazebo_ros_p3d.so", "mecanum_odometry", "differential"),
        ("libgazebo_ros_planar_move.so", "diff_drive", "omni"),
        ("ignition-gazebo-diff-drive-system", "ignition::gazebo::systems::DiffDrive",
         "differential"),
        ("libgz-sim8-velocity-control-system.so", "gz::sim::systems::VelocityControl", "omni"),
        ("libhector_gazebo_ros_force_based_move.so", "move", "omni"),
    ],
)  # fmt: skip
def test_a_plugin_is_what_its_file_or_class_says(file, name, drive, tmp_path):
    own = two_wheels(*pair(), plugin(file, name=name))
    spec = load_robot(own.write(tmp_path))
    assert spec.drive == drive


def test_the_tyre_counts_for_radius_and_separation(tmp_path):
    assert load_robot(hub_first().write(tmp_path)).wheel_radius == 0.08
    spec = load_robot(inboard_tyres().write(tmp_path))
    assert spec.wheel_separation == pytest.approx(0.358)
    # A base of 1e-13 m was refused by the name of a key that the file does not have.
    tyre = solid(cylinder(0.08, 0.04))
    wheels = [
        made_wheel(side, (x, y, 0.08), tyre)
        for side, x, y in (("left", 0.0, 0.2), ("right", 1e-13, -0.2))
    ]
    assert load_robot(two_wheels(*wheels).write(tmp_path)).wheel_base == 0.0


def test_a_plugin_is_told_if_it_denies_the_shapes_and_counts_without(tmp_path):
    lengths = "<wheel_separation>0.4</wheel_separation><wheel_diameter>0.13</wheel_diameter>"
    own = two_wheels(*pair(), plugin("libgazebo_ros_diff_drive.so", JOINTS.format(lengths)))
    spec = load_robot(own.write(tmp_path))
    assert (spec.wheel_radius, spec.wheel_separation) == (0.05, pytest.approx(0.3))
    notes = notes_of(own, tmp_path)
    assert "states wheel_radius 0.065 m; the wheels' collision shapes say 0.05 m" in notes
    assert "states wheel_separation 0.4 m" in notes
    stated = Own(own.urdf, LIMITS + "wheel_radius: 0.065\nwheel_separation: 0.4\n")
    assert "states wheel" not in notes_of(stated, tmp_path)
    bare = [
        link(f"{side}_wheel", mass=inertial(0.3, 4e-4))
        + joint(f"{side}_wheel_joint", "base_link", f"{side}_wheel", (0, y, 0.07),
                kind="continuous")
        for side, y in (("left", 0.15), ("right", -0.15))
    ]  # fmt: skip
    lengths = "<wheel_radius>0.07</wheel_radius>"
    own = two_wheels(*bare, plugin("gz-sim-diff-drive-system", JOINTS.format(lengths)))
    assert load_robot(own.write(tmp_path)).wheel_radius == 0.07


def test_controllers_say_drive_and_limits_and_multipliers_count(tmp_path):
    spec = load_robot(mecanum_by_controller().write(tmp_path / "a"))
    assert (spec.drive, len(spec.wheels_left)) == ("omni", 2)
    spec = load_robot(limits_by_controller().write(tmp_path / "b"))
    assert (spec.drive, spec.max_vel_x, spec.max_vel_theta) == ("differential", 0.6, 1.7)
    assert (spec.acc_lim_x, spec.acc_lim_theta) == (1.1, 2.2)
    text = DIFFERENTIAL.replace(
        "      wheel_radius: 0.05\n",
        "      wheel_radius: 0.04\n      left_wheel_radius_multiplier: 1.25\n"
        "      wheel_separation_multiplier: 2.0\n",
    )
    own = two_wheels(*pair(), CONTROL.format("c.yaml"), **{"c.yaml": text})
    assert "states wheel_separation 0.6 m" in notes_of(own, tmp_path)
    assert "wheel_radius" not in notes_of(own, tmp_path)


@pytest.mark.parametrize(
    ("old", "new", "missing"),
    [
        ("has_velocity_limits: true", "has_velocity_limits: false", "max_vel_x"),
        ("linear.x.max_velocity: 0.6", "linear.x.max_velocity: .nan", "max_vel_x"),
        ("linear.x.max_velocity: 0.6", "linear.x.max_velocity: 30.0", "max_vel_x"),
    ],
)
def test_a_limit_that_is_switched_off_or_a_placeholder_is_asked_for(old, new, missing, tmp_path):
    assert old in DIFFERENTIAL
    own = two_wheels(*pair(), CONTROL.format("c.yaml"), settings="model: c\n",
                     **{"c.yaml": DIFFERENTIAL.replace(old, new)})  # fmt: skip
    with pytest.raises(RobotModelError, match=f"does not tell {missing}"):
        load_robot(own.write(tmp_path))


def test_a_controller_file_that_is_not_there_is_told_and_robot_yaml_names_one(tmp_path):
    own = two_wheels(*pair(), CONTROL.format("nowhere.yaml"))
    assert "its <parameters> are not used: there is no file" in notes_of(own, tmp_path)
    own = two_wheels(*pair(), '<ros2_control name="base" type="system"/>')
    assert "controllers: [path/to/controllers.yaml]" in notes_of(own, tmp_path)
    named = Own(own.urdf, "controllers: [c.yaml]\n", {"c.yaml": DIFFERENTIAL})
    assert load_robot(named.write(tmp_path)).max_vel_x == 0.6
    with pytest.raises(RobotModelError, match=r"controllers: there is no file .*d\.yaml"):
        load_robot(Own(own.urdf, "controllers: [d.yaml]\n").write(tmp_path))


@pytest.mark.parametrize(
    "kind",
    ["four_wheel_steering_controller/FourWheelSteeringController",
     "tricycle_controller/TricycleController",
     "ackermann_steering_controller/AckermannSteeringController"],
)  # fmt: skip
def test_steering_controllers_are_refused_by_name(kind, tmp_path):
    text = f"controller_manager:\n  ros__parameters:\n    drive: {{type: {kind}}}\n"
    own = four_wheels(CONTROL.format("c.yaml"), **{"c.yaml": text})
    with pytest.raises(RobotModelError, match=rf"steers like a car .*{kind}"):
        load_robot(own.write(tmp_path))


def test_a_placeholder_is_not_believed_and_a_limit_is_and_says_where_it_is_from(tmp_path):
    own = two_wheels(*fast_wheels(), settings=ACCELERATIONS)
    with pytest.raises(RobotModelError) as caught:
        load_robot(own.write(tmp_path))
    message = str(caught.value)
    assert "does not tell max_vel_x, max_vel_theta (the velocity limit 100 rad/s" in message
    assert "taken for a placeholder" in message
    own = two_wheels(*fast_wheels(12.0), settings=ACCELERATIONS)
    assert load_robot(own.write(tmp_path)).max_vel_x == pytest.approx(0.6)
    note = "max_vel_x is 0.6 (guessed: velocity limit 12 rad/s of joint left_wheel_joint"
    assert note in notes_of(own, tmp_path)


def test_the_lidar_that_looks_ahead_wins_though_it_is_weaker(tmp_path):
    assert load_robot(rear_first().write(tmp_path)).lidar.frame == "front"
    back = lidar("back", (-0.19, 0, 0.17), "0 0 3.14159", rays=900, far=30.0, first=-1, last=1)
    own = two_wheels(*pair(), back)
    assert load_robot(own.write(tmp_path)).lidar.frame == "laser"


def test_every_value_has_an_origin(tmp_path):
    account = account_of(plugin_drive().write(tmp_path))
    said = {name: source for name, _, source in account.rows}
    assert said["max_vel_x"] == "plugin gz::sim::systems::DiffDrive"
    assert said["wheel_radius"] == "collision shapes of the wheels"
    assert said["lidar.rays"] == "ray sensor on link laser"
    assert said["model"] == "own.robot.yaml"
    assert not account.missing
    account = account_of(two_wheels(*fast_wheels(), settings="model: f\n").write(tmp_path))
    assert [name for name, _ in account.missing] == [
        "max_vel_x", "max_vel_theta", "acc_lim_x", "acc_lim_theta",
    ]  # fmt: skip
    account = account_of("turtlebot3_waffle")
    assert {source for _, _, source in account.rows} <= {
        "robot.yaml", "default", "name of the file",
    }  # fmt: skip


def test_latin_1_is_read_if_the_file_says_so(tmp_path):
    path = two_wheels(*pair(), name="B\u00e4r").write(tmp_path)
    text = path.read_text(encoding="utf-8").partition("\n")[2]
    first = '<?xml version="1.0" encoding="ISO-8859-1"?>\n'
    path.write_bytes((first + text).encode("latin-1"))
    assert open_robot(path).model.name == "B\u00e4r"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(RobotModelError, match=r"line 1 is not utf-8; save .* encoding="):
        load_robot(path)
    path.write_bytes(b'<?xml version="1.0" encoding="klingon"?>\n<robot name="a"/>')
    with pytest.raises(RobotModelError, match="unknown encoding: klingon"):
        load_robot(path)


def test_latin_1_is_read_in_xacro_and_prefixes_need_no_declaration(tmp_path):
    text = two_wheels(*pair(), name="B\u00e4r").urdf.partition("\n")[2]
    text = text.replace("<robot ", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" ')
    part = '<?xml version="1.0" encoding="ISO-8859-1"?>\n<robot><!-- \u00fc --></robot>'
    (tmp_path / "part.xacro").write_bytes(part.encode("latin-1"))
    text = text.replace("</robot>", '<xacro:include filename="part.xacro"/></robot>')
    path = tmp_path / "bear.urdf.xacro"
    first = '<?xml version="1.0" encoding="ISO-8859-1"?>\n'
    path.write_bytes((first + text).encode("latin-1"))
    (tmp_path / "robot.yaml").write_text(LIMITS, encoding="utf-8")
    assert open_robot(path).model.name == "B\u00e4r"
    prefixed = SDF.replace("<topic>cmd_vel</topic>", "<gz:topic>cmd_vel</gz:topic>")
    assert load_robot(Folder("\n" + prefixed).write(tmp_path)).drive == "differential"


MACRO = """<?xml version="1.0"?>
<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:macro name="acme_base" params="prefix mesh:=none *origin"><link name="${prefix}b"/>
  </xacro:macro>
</robot>
"""


def test_a_xacro_of_macros_says_how_to_call_them(tmp_path):
    path = tmp_path / "base.urdf.xacro"
    path.write_text(MACRO, encoding="utf-8")
    with pytest.raises(RobotModelError) as caught:
        load_robot(path)
    message = str(caught.value)
    assert "defines the macro 'acme_base' and no link" in message
    assert '<xacro:include filename="base.urdf.xacro"/><xacro:acme_base prefix="...">' in message
    assert "mesh=" not in message
    (tmp_path / "robot.urdf.xacro").write_text(
        '<robot name="r"><xacro:include filename="base.urdf.xacro"/></robot>', encoding="utf-8"
    )
    with pytest.raises(RobotModelError, match=r"Start with .* includes it: robot\.urdf\.xacro"):
        load_robot(path)


def test_a_xacro_argument_that_nothing_uses_is_an_error(tmp_path):
    text = two_wheels(*pair()).urdf.replace(
        "<robot ", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" '
    ).replace("</robot>", '<xacro:arg name="big" default="1"/></robot>')  # fmt: skip
    (tmp_path / "a.urdf.xacro").write_text(text, encoding="utf-8")
    settings = tmp_path / "robot.yaml"
    settings.write_text(LIMITS + "xacro_args: {bgi: 2}\n", encoding="utf-8")
    with pytest.raises(SwarmError, match=r"unknown xacro argument 'bgi'.*did you mean 'big'"):
        load_robot(tmp_path / "a.urdf.xacro")
    settings.write_text(LIMITS + "xacro_args: {big: 2}\n", encoding="utf-8")
    assert load_robot(tmp_path / "a.urdf.xacro").drive == "differential"


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("lidar: {rays: 90.5}", "lidar.rays is 90.5; expected an integer"),
        ("packages: [nowhere]", "packages: there is no folder 'nowhere'"),
        ("wheel_base: []", "wheel_base is []; expected a number"),
        ("controllers: c.yaml", "controllers is 'c.yaml'; expected a list of files"),
    ],
)
def test_nothing_of_robot_yaml_is_cut_or_ignored(line, message, tmp_path):
    with pytest.raises(SwarmError) as caught:
        load_robot(two_wheels(*pair(), settings=f"{LIMITS}{line}\n").write(tmp_path))
    assert message in str(caught.value)


class TestSdf:
    def test_a_model_folder_is_a_robot(self, tmp_path):
        folder = Folder().write(tmp_path)
        for path in (folder, folder / "model.sdf"):
            spec = load_robot(path)
            assert (spec.model, spec.drive) == ("tb", "differential")
            assert (spec.wheel_radius, spec.wheel_separation) == (0.033, pytest.approx(0.288))
            assert (spec.max_vel_x, spec.acc_lim_theta) == (0.26, 3.2)
            assert (spec.lidar.frame, spec.lidar.rays) == ("base_scan", 360)
            assert spec.lidar.z == pytest.approx(0.141)
            assert spec.lidar.x == pytest.approx(-0.064)
        model = open_robot(folder).model
        assert model.groups[0].mass == pytest.approx(1.4779)
        assert [group.joint for group in model.groups] == ["", "left_joint", "right_joint"]
        places = model.root_from_groups()
        for group, place in zip(model.groups[1:], places[1:], strict=True):
            np.testing.assert_allclose(place[:3, :3] @ group.axis, [0, 1, 0], atol=1e-5)

    def test_colours_are_kept(self, tmp_path):
        visual = (
            '<link name="base_link"><visual name="v"><geometry><sphere><radius>0.1</radius>'
            "</sphere></geometry><material><diffuse>0.1 0.2 0.3</diffuse></material></visual>"
        )
        text = SDF.replace('<link name="base_link">', visual)
        urdf = open_robot(Folder(text).write(tmp_path)).urdf
        assert '<color rgba="0.1 0.2 0.3 1.0"' in urdf

    def test_a_version_in_fuels_cache_is_no_name(self, tmp_path):
        folder = Folder().write(tmp_path)
        assert load_robot(folder.rename(tmp_path / "2")).model == tmp_path.name

    def test_a_joint_beside_its_link(self, tmp_path):
        old = '<joint name="left_joint" type="revolute">'
        text = SDF.replace(old, old + "<pose>0 0 0.02 0 0 0</pose>")
        spec = load_robot(Folder(text).write(tmp_path))
        assert spec.wheel_separation == pytest.approx(0.288)

    def test_xacro_of_sdf(self, tmp_path):
        text = SDF.replace("<sdf ", '<sdf xmlns:xacro="http://www.ros.org/wiki/xacro" ').replace(
            '<model name="tb">', '<xacro:arg name="speed" default="0.3"/><model name="tb">'
        )
        text = text.replace("velocity>0.26<", "velocity>$(arg speed)<")
        path = tmp_path / "gz_tb.sdf.xacro"
        path.write_text(text, encoding="utf-8")
        spec = load_robot(path)
        assert (spec.model, spec.max_vel_x) == ("gz_tb", 0.3)

    @pytest.mark.parametrize(
        ("old", "new", "message"),
        [
            ("<link name=\"base_footprint\"/>", "<static>true</static>", "is <static>"),
            ("<link name=\"base_footprint\"/>", "<include/>", "holds other models"),
            ("<parent>base_footprint<", "<parent>nowhere<", "no link 'nowhere'; known: base"),
            ("expressed_in=\"__model__\"", "expressed_in=\"up\"", "no frame 'up'"),
            ("relative_to=\"left_wheel\"", "relative_to=\"right_wheel\"", "go round: right_wheel"),
            ("<size>0.266 0.266", "<size>0.266", "is '0.266 0.094'; expected 3 numbers"),
            ("type=\"ball\"", "type=\"bal\"", "is of type 'bal'"),
            ("<mass>1.3729", "<mass>much", "<mass> is 'much'"),
            ("<model name=\"tb\">", "<world name=\"w\"/><model name=\"tb\">", "is a world"),
        ],
    )  # fmt: skip
    def test_what_is_wrong_is_told(self, old, new, message, tmp_path):
        assert old in SDF
        with pytest.raises(RobotModelError) as caught:
            load_robot(Folder(SDF.replace(old, new)).write(tmp_path))
        assert message in str(caught.value)

    def test_a_config_that_names_nothing(self, tmp_path):
        folder = Folder().write(tmp_path)
        (folder / "model.sdf").unlink()
        with pytest.raises(RobotModelError, match="names no SDF file that is there"):
            load_robot(folder)


@pytest.mark.parametrize("make", [hub_first, inboard_tyres, Folder])
def test_descriptions_of_what_we_read_are_without_notes_on_elements(make, tmp_path):
    assert "not known" not in "\n".join(open_robot(make().write(tmp_path)).model.notes)


SLOTCAR = plugin(
    "libslotcar.so",
    "<nominal_drive_speed>0.7</nominal_drive_speed><nominal_turn_speed>0.4</nominal_turn_speed>"
    "<nominal_drive_acceleration>0.5</nominal_drive_acceleration><tire_radius>0.06</tire_radius>"
    "<nominal_turn_acceleration>1.1</nominal_turn_acceleration><base_width>0.3</base_width>{}",
    name="slotcar",
)


def test_the_slotcar_of_rmf_is_a_drive_with_limits(tmp_path):
    own = two_wheels(*pair(), SLOTCAR.format(""), settings="model: own\n")
    spec = load_robot(own.write(tmp_path))
    assert (spec.drive, spec.max_vel_x, spec.max_vel_theta) == ("differential", 0.7, 0.4)
    assert (spec.acc_lim_x, spec.acc_lim_theta) == (0.5, 1.1)
    assert "plugin libslotcar.so states wheel_radius 0.06 m" in notes_of(own, tmp_path)
    car = two_wheels(*pair(), SLOTCAR.format("<steering>ackermann</steering>"))
    with pytest.raises(RobotModelError, match="steers like a car"):
        load_robot(car.write(tmp_path))


def test_what_a_run_does_not_do_as_stated_is_told(tmp_path):
    drawn = "<link name='arm'><visual><geometry><box size='1 1 1'/></geometry></visual></link>"
    own = two_wheels(*fast_wheels(5.0), drawn, joint("arm_joint", "base_link", "arm"))
    notes = notes_of(own, tmp_path)
    assert "max_vel_x 0.5 takes 10 rad/s of the wheels; the velocity limit of joint" in notes
    assert "link arm: a <visual> without <collision> is only drawn" in notes
    assert "Hz" not in notes
    for rate, comes in ((7, 10), (100, 10), (3, 3.333)):
        own = two_wheels(*fast_wheels(20.0), settings=LIMITS + f"lidar: {{rate: {rate}}}\n")
        assert f"rate is {rate} Hz; its scans come at {comes} Hz" in notes_of(own, tmp_path)
        assert "rad/s" not in notes_of(own, tmp_path)


def test_inertias_that_the_shapes_replace_are_not_checked(tmp_path):
    made = two_wheels(*pair())
    wrong = Own(made.urdf.replace('ixx="0.08"', 'ixx="5.2e13"'), LIMITS + "inertia: shapes\n")
    assert wrong.urdf != made.urdf
    right = open_robot(Own(made.urdf, wrong.settings).write(tmp_path / "right")).model.groups
    for a, b in zip(open_robot(wrong.write(tmp_path)).model.groups, right, strict=True):
        assert (a.inertia == b.inertia).all()
    folder = Folder(re.sub("<ixx>[^<]*", "<ixx>much", SDF)).write(tmp_path)
    (folder / "robot.yaml").write_text(wrong.settings)
    assert (folder / "model.sdf").read_text() != SDF
    open_robot(folder)


def test_a_mesh_of_implausible_size_is_told_once(tmp_path):
    shape = trimesh.creation.box((300.0, 240.0, 80.0)).export(file_type="stl_ascii")
    plate = link("plate", '<mesh filename="plate.stl"/>', inertial(1.0, 0.1))
    own = two_wheels(*pair(), plate, joint("plate_joint", "base_link", "plate"))
    with pytest.raises(RobotModelError, match="the mesh is 300 m long") as caught:
        load_robot(Own(own.urdf, own.settings, {"plate.stl": shape}).write(tmp_path))
    assert str(caught.value).count("300 m long") == 1
