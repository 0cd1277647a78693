import pytest

from tests.document_blocks import Block, blocks_of

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


def test_marked_blocks_are_found_and_others_are_not() -> None:
    assert list(blocks_of(DOCUMENT)) == [
        Block("save", "plan.yaml", "name: hall\n\nwalls: []\n", 5),
        Block("run", "", "first\nsecond\n", 12),
        Block("long", "", "third\n", 17),
    ]


@pytest.mark.parametrize("text", ["<!-- run sometimes -->\n\n    x\n", "<!-- run -->\nprose\n"])
def test_a_mark_that_means_nothing_is_an_error(text: str) -> None:
    with pytest.raises(ValueError, match="line 1"):
        list(blocks_of(text))
