"""Messages that travel behind another one."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarm_common.middleware import joined
from swarm_common.middleware.rejections import RejectedError

messages = st.lists(st.binary(max_size=40), min_size=1, max_size=joined.MOST + 1)


@given(parts=messages)
def test_what_was_joined_comes_apart(parts: list[bytes]) -> None:
    data = joined.join(*parts)
    assert joined.split(data) == parts
    assert data.startswith(parts[0]), "to a reader of the first message the others are not there"


@given(data=st.binary(max_size=60))
def test_any_bytes_are_split_or_rejected(data: bytes) -> None:
    if not data.endswith(joined.MARK):
        assert joined.split(data) is None
    try:
        parts = joined.split(data + joined.MARK)
    except RejectedError:
        return
    assert parts is not None
    assert b"".join(parts) == data[: sum(map(len, parts))]


@pytest.mark.parametrize(("count", "size"), [(joined.MOST + 1, 0), (1, 9), (2**32 - 1, 0)])
def test_sizes_that_do_not_fit_are_named(count: int, size: int) -> None:
    numbers = size.to_bytes(4, "little") + count.to_bytes(4, "little")
    with pytest.raises(RejectedError, match="cannot"):
        joined.split(b"12345678" + numbers + joined.MARK)
