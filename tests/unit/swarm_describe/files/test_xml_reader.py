"""XML as Gazebo's reader takes it, and what stays refused."""

import time
import xml.etree.ElementTree as ET
from itertools import pairwise
from xml.parsers.expat import ExpatError

import pytest

from swarm_common.model.errors import WorldError
from swarm_describe.files.xml_reader import read_xml
from swarm_describe.worlds.reader import read_world
from tests.fakes.scenes import read_bodies

BOX = (
    "<model name='b'><static>1</static><pose>2 -1.5 0.5 0 0 0</pose><link name='l'><collision "
    "name='c'><geometry><box><size>1 1 1</size></box></geometry></collision></link></model>"
)
WORLD = f"<sdf version='1.6'><world name='w'>{BOX}</world></sdf>"


@pytest.mark.parametrize(
    "data",
    [
        WORLD.replace("<model", "<!-- gz sim -s --iterations 10 --><model").encode(),
        WORLD.replace("<model", "<gz:policies><a>1</a></gz:policies><model").encode(),
        WORLD.replace("<model", "<gazebo:frame>x</gazebo:frame><model").encode(),
        b"\n \n<?xml version='1.0'?>" + WORLD.encode(),
        b"\xef\xbb\xbf\r\n<?xml version='1.0'?>" + WORLD.encode(),
        b"<!-- licence --><?xml version='1.0'?>" + WORLD.encode(),
        b"<?xml version='1.0' encoding='utf-16'?>" + WORLD.encode(),
        b"<?xml version='1.0' encoding='UTF8-ish'?>" + WORLD.encode(),
        WORLD.replace("name='w'", "name='a & b'").encode(),
        WORLD.replace("name='w'", "name='&nbsp;'").encode(),
        WORLD.replace("name='w'", "name='a<b'").encode(),
        WORLD.replace("name='w'", "name='w'kind=\"x\"").encode(),
        WORLD.replace("name='w'", "name='M\u00fcller'").encode("latin-1"),
        WORLD.replace("2 -1.5 0.5", "2-1.5 .5").encode(),
        WORLD.replace("2 -1.5 0.5 0 0 0", "<![CDATA[2 -1.5 0.5 0 0 0]]><!-- -- -->").encode(),
        b"<!DOCTYPE sdf>" + WORLD.encode(),
        WORLD.encode("utf-16"),
    ],
)
def test_what_gazebo_reads_is_read(tmp_path, data):
    path = tmp_path / "w.sdf"
    path.write_bytes(data)
    (body,) = read_bodies(path)
    assert body.world_from_body[:3, 3].tolist() == [2.0, -1.5, 0.5]


def test_files_are_read_as_meant_and_by_the_standard_library():
    text = b"<a b='&quot;&amp;#65; &x; <'>1 &lt; 2 &#x41; &#0; ]]> <![CDATA[<&]]><!-- -- --></a>"
    root = read_xml(text).root
    assert root.attrib == {"b": '"&#65; &x; <'}
    assert root.text == "1 < 2 A &#0; ]]> <&"
    assert read_xml(b"left <a/> over & out").outside == "left   over & out"
    text = "<?xml version='1.0'?>\n<a b='1&amp;2'>x<c d='&#10;'/>y<!-- z --></a>"
    assert ET.tostring(read_xml(text.encode()).root) == ET.tostring(ET.fromstring(text))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"<a><!-- -- -->\n<b></a>", "line 2"),
        (b"<a><!-- without end", "line 1"),
        (b"<a><!-- -- --><b c='></b></a>", "line 1"),
        (b"<a/><b/>", "outermost elements: <a>, <b>"),
        (b"<!-- -- -->", "outermost elements: none"),
        (b"plain", "line 1"),
        (b"<a>\0</a>", "line 1"),
        (b"<a b='1' b='2'/>", "duplicate attribute"),
    ],
)
def test_what_gazebo_refuses_is_refused(data, message):
    with pytest.raises((ExpatError, ValueError), match=message):
        read_xml(data)


def test_entities_that_grow_are_refused():
    names = "abcdefghij"
    entities = "<!ENTITY a 'lol'>" + "".join(
        f"<!ENTITY {name} '{f'&{before};' * 10}'>" for before, name in pairwise(names)
    )
    for around in ("{}", "{}<!-- -- -->"):
        text = around.format(f"<!DOCTYPE l [{entities}]><l>&j;</l>")
        with pytest.raises((ExpatError, ValueError)):
            read_xml(text.encode())
    with pytest.raises((ExpatError, ValueError)):
        read_xml(b"<!DOCTYPE l [<!ENTITY f SYSTEM 'file:///etc/hostname'>]><l>&f;</l>")


@pytest.mark.parametrize("piece", ["<a b='<!-- -- -->", "<a ", "<!-- -- ", "&#", "<![CDATA[", '<"'])
def test_time_grows_with_the_length(piece):
    start = time.process_time()
    with pytest.raises((ExpatError, ValueError)):
        read_xml((piece * 100_000).encode())
    assert time.process_time() - start < 5.0


def test_text_around_the_world_is_told(tmp_path):
    path = tmp_path / "w.sdf"
    path.write_text(f"{WORLD} and so on")
    assert read_world(path).notes == ("w.sdf: the text around <sdf> in w.sdf is ignored",)


def test_a_world_of_stage_is_no_xml(tmp_path):
    path = tmp_path / "cave.world"
    path.write_text('define floorplan model ( color "gray30" )\n')
    with pytest.raises(WorldError, match="no XML"):
        read_world(path)
