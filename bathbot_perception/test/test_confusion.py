"""The confusion matrix."""

import numpy as np
from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.evaluation.average_precision import PictureResult
from bathbot_perception.evaluation.confusion import BACKGROUND, confusion
from bathbot_perception.regions import Region
from hypothesis import given
from hypothesis import strategies as st

BOX, AWAY = (10.0, 10.0, 30.0, 40.0), (60.0, 60.0, 90.0, 80.0)
ID = {name: index for index, name in enumerate(SKIN_CLASSES)}

regions = st.lists(
    st.builds(
        lambda name, score, left, top, width, height: Region(
            name, score, (left, top, left + width, top + height)
        ),
        st.sampled_from(SKIN_CLASSES),
        st.floats(0.0, 1.0),
        *[st.floats(0.0, 60.0)] * 2,
        *[st.floats(5.0, 40.0)] * 2,
    ),
    max_size=6,
)


@given(truths=regions, found=regions, score=st.floats(0.0, 1.0))
def test_every_region_is_counted_once(truths, found, score):
    counts = confusion([PictureResult(truths, found)], score)
    shown = [region for region in found if region.score >= score]
    for name, index in ID.items():
        assert counts[index].sum() == sum(region.name == name for region in truths)
        assert counts[:, index].sum() == sum(region.name == name for region in shown)
    assert counts[BACKGROUND, BACKGROUND] == 0


def test_by_hand():
    truths = [Region("Hand_skin", 1.0, BOX), Region("Foot_skin", 1.0, AWAY)]
    found = [Region("Foot_skin", 0.9, BOX), Region("Face_skin", 0.5, (0.0, 0.0, 5.0, 5.0))]
    counts = confusion([PictureResult(truths, found)], 0.3)
    expected = np.zeros_like(counts)
    expected[ID["Hand_skin"], ID["Foot_skin"]] = 1
    expected[ID["Foot_skin"], BACKGROUND] = 1
    expected[BACKGROUND, ID["Face_skin"]] = 1
    assert (counts == expected).all()


@given(truths=regions, found=regions, hard=regions)
def test_difficult_regions_only_excuse_what_lies_on_them(truths, found, hard):
    plain, excused = (confusion([PictureResult(truths, found, some)], 0.0) for some in ((), hard))
    assert (plain[:BACKGROUND] == excused[:BACKGROUND]).all()
    assert (plain[BACKGROUND] >= excused[BACKGROUND]).all()
    assert not confusion([PictureResult([], hard, hard)], 0.0).any()
