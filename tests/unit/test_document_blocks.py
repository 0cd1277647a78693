from pathlib import Path

import pytest

from tests.document_blocks import Block, blocks_of, unmarked_fences

ROOT = Path(__file__).parents[2]

DOCUMENT = """\
Prose, and a block that nobody marked:

    rm -rf /

<!-- save plan.yaml -->
```yaml
name: hall

walls: []
```

<!-- run -->

    first
    second

<!-- run long -->
    third
"""


def test_marked_blocks_are_found_and_others_are_not():
    assert list(blocks_of(DOCUMENT)) == [
        Block("save", "plan.yaml", "name: hall\n\nwalls: []\n", 5),
        Block("run", "", "first\nsecond\n", 12),
        Block("long", "", "third\n", 17),
    ]


@pytest.mark.parametrize("text", ["<!-- run sometimes -->\n\n    x\n", "<!-- run -->\nprose\n"])
def test_a_mark_that_means_nothing_is_an_error(text):
    with pytest.raises(ValueError, match="line 1"):
        list(blocks_of(text))


def test_a_fence_has_a_mark_right_above_it_or_none():
    text = (
        "```\na\n```\n<!-- run -->\n```\nb\n```\n<!-- not run: no engine -->\n```sh\nc\n```\n\n"
        "<!-- not run: -->\n```\nd\n```\n"
    )
    assert unmarked_fences(text) == [1, 14]


def test_every_block_of_the_ros_page_is_run_or_says_why_not():
    text = (ROOT / "docs" / "ros.md").read_text("utf-8")
    assert not unmarked_fences(text)
    assert len([block for block in blocks_of(text) if block.kind == "long"]) >= 6
