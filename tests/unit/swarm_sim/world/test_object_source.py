"""Descriptions of things that come at run time: read as worlds are, refused with the cause."""

import pytest

from swarm_sim.world.object_source import is_object, read_object
from swarm_sim.world.request_checks import Reason, RefusedError

LINK = (
    "<link name='l'><collision name='c'><geometry><box><size>{0} 1 1</size></box></geometry>"
    "</collision></link>"
)
MODEL = f"<sdf version='1.7'><model name='crate'>{LINK.format(1)}</model></sdf>"
XACRO = (
    "<sdf version='1.7' xmlns:xacro='http://www.ros.org/wiki/xacro'><xacro:property name='n' "
    f"value='2'/><model name='crate'>{LINK.format('${n}')}</model></sdf>"
)


def test_text_is_read_as_gazebo_reads_it(tmp_path):
    text = MODEL.replace("<link", "<!-- a -- b --><gz:x/><link", 1)
    assert len(read_object("", text, tmp_path).parts) == 1


def test_a_thing_in_xacro(tmp_path):
    path = tmp_path / "crate.sdf.xacro"
    path.write_text(XACRO)
    assert is_object(str(path), "", False, tmp_path)
    (part,) = read_object(str(path), "", tmp_path).parts
    assert part.shape.size == (2.0, 1.0, 1.0)
    with pytest.raises(RefusedError, match="give a uri"):
        read_object("", XACRO, tmp_path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (MODEL.replace("1 1 1", "1 1"), "<size> of crate::l is '1 1'"),
        (MODEL.replace("link", "lnik"), "<lnik> in model 'crate' holds a <collision>"),
        (MODEL.replace("<model", "<group><model").replace("</sdf>", "</group></sdf>"), "0 <model>"),
        (MODEL + MODEL, "outermost elements: <sdf>, <sdf>"),
    ],
)
def test_the_cause_is_told(tmp_path, text, message):
    with pytest.raises(RefusedError) as caught:
        read_object("", text, tmp_path)
    assert caught.value.reason is Reason.BAD_MODEL
    assert message in str(caught.value)
