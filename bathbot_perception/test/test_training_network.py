from dataclasses import replace

import cv2
import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="training needs the extra `train`")

from bathbot_perception.classes import SKIN_CLASSES  # noqa: E402
from bathbot_perception.detection.detector import load  # noqa: E402
from bathbot_perception.errors import ModelError, TrainingError  # noqa: E402
from bathbot_perception.pictures.voc import Annotation, list_samples, write_annotation  # noqa: E402
from bathbot_perception.regions import Region  # noqa: E402
from bathbot_perception.training.data.batches import Batch  # noqa: E402
from bathbot_perception.training.data.dataset import load_source  # noqa: E402
from bathbot_perception.training.network.checkpoint import Average, Run, optimiser_of, read_state, save_run  # noqa: E402
from bathbot_perception.training.network.export import export  # noqa: E402
from bathbot_perception.training.network.loss import complete_overlap, detection_loss, match  # noqa: E402
from bathbot_perception.training.network.network import STRIDES, Yolov5s, decode  # noqa: E402
from bathbot_perception.training.network.unfold import network_from_onnx  # noqa: E402
from bathbot_perception.training.parallel import ParallelGradient, split_batch  # noqa: E402
from bathbot_perception.training.run import make_optimiser, start_run, train_step  # noqa: E402
from bathbot_perception.training.settings import TrainSettings, rate_at  # noqa: E402
from bathbot_perception.training.train import train  # noqa: E402

ANCHORS = torch.tensor(
    [[[8, 8], [16, 16], [12, 30]], [[30, 30], [40, 20], [30, 70]], [[90, 90], [80, 200], [200, 150]]]
)


def test_the_network_has_the_size_and_the_outputs_of_yolov5s():
    model = Yolov5s(6, ANCHORS)
    assert 6.9e6 < sum(p.numel() for p in model.parameters()) < 7.3e6
    shapes = [tuple(out.shape) for out in model(torch.rand(2, 3, 64, 96))]
    assert shapes == [(2, 3, 64 // s, 96 // s, 11) for s in STRIDES]


def test_decoding_by_hand():
    """Raw zeros are sigmoids of 1/2: the middle of the cell, the size of the anchor."""
    decoded = decode(torch.zeros(1, 3, 4, 5, 11), ANCHORS[1], 16)[0]
    assert decoded.shape == (60, 11)
    index = 1 * 20 + 2 * 5 + 3  # anchor 1, row 2, column 3
    assert decoded[index, :4].tolist() == pytest.approx([56.0, 40.0, 40.0, 20.0])
    assert decoded[index, 4:].tolist() == pytest.approx([0.5] * 7)


def test_a_box_belongs_to_its_cell_and_the_two_nearest_neighbours():
    found = match(
        torch.tensor([[0, 4, 3.2, 5.8, 1.0, 1.0]]), torch.tensor([[1.0, 1.0], [9, 9], [1, 9]]), 10, 10
    )
    cells = set(zip(found.column.tolist(), found.row.tolist(), strict=True))
    assert cells == {(3, 5), (2, 5), (3, 6)}
    assert set(found.anchor.tolist()) == {0}


def test_a_box_in_the_corner_stays_on_the_grid():
    found = match(torch.tensor([[0, 4, 9.9, 0.1, 1.0, 1.0]]), torch.tensor([[1.0, 1.0]] * 3), 10, 10)
    assert found.column.max() <= 9
    assert found.row.min() >= 0


def test_overlap_is_one_only_for_the_same_box():
    boxes = torch.tensor([[5.0, 5.0, 4.0, 2.0]])
    assert complete_overlap(boxes, boxes).item() == pytest.approx(1.0, abs=1e-5)
    assert complete_overlap(boxes, boxes + torch.tensor([[1.0, 0, 0, 0]])).item() < 0.7
    assert complete_overlap(boxes, boxes + torch.tensor([[50.0, 0, 0, 0]])).item() < 0.0


def test_the_right_answer_costs_less():
    raw = [torch.full((1, 3, 64 // s, 64 // s, 11), -6.0) for s in STRIDES]
    targets = torch.tensor([[0, 2, 36.0, 36.0, 16.0, 16.0]])
    anchors = ANCHORS.float()
    wrong = detection_loss(raw, targets, anchors).total
    right = [item.clone() for item in raw]
    right[0][0, 1, 4, 4] = torch.tensor([0, 0, 0, 0, 6, -6, -6, 6, -6, -6, -6.0])
    assert detection_loss(right, targets, anchors).total < wrong
    empty = detection_loss(raw, torch.zeros(0, 6), anchors)
    assert empty.box == empty.category == 0.0


def test_the_rate_warms_up_and_falls():
    settings = TrainSettings(rate=1e-3, warmup=10, rate_end=0.1)
    assert rate_at(0, 0.0, settings) == pytest.approx(1e-4)
    assert rate_at(100, 0.0, settings) == pytest.approx(1e-3)
    assert rate_at(100, 1.0, settings) == pytest.approx(1e-4)


def test_two_threads_give_the_mean_gradient_of_their_halves():
    torch.manual_seed(0)
    batch = Batch(
        torch.rand(4, 3, 64, 64), torch.tensor([[0, 2, 30.0, 30, 20, 20], [3, 1, 20.0, 40, 10, 30]])
    )
    model = Yolov5s(6, ANCHORS)
    both = ParallelGradient(model, 2)
    both.compute(batch)
    together = model.heads[0].weight.grad.clone()
    model.zero_grad()
    alone = ParallelGradient(model, 1)
    for part in split_batch(batch, 2):
        alone.compute(part)  # gradients add up
    assert torch.allclose(together, model.heads[0].weight.grad / 2, atol=1e-4)
    both.close()
    alone.close()


@pytest.fixture
def data_set(tmp_path):
    folder = tmp_path / "squares"
    (folder / "images").mkdir(parents=True)
    (folder / "annotations").mkdir()
    for index in range(10):
        picture = np.zeros((64, 64, 3), np.uint8)
        picture[20:40, 10 + index : 40 + index] = 200
        cv2.imwrite(str(folder / f"images/{index}.png"), picture)
        region = Region("Hand_skin", 1.0, (10.0 + index, 20.0, 40.0 + index, 40.0))
        write_annotation(folder / f"annotations/{index}.xml", Annotation(f"{index}.png", 64, 64, (region,)))
    return folder


def test_from_data_to_a_model_that_the_runtime_takes(data_set, tmp_path):
    """Some steps, a stop, some more; the exported network is loaded and asked."""
    out, settings = tmp_path / "run", TrainSettings(minutes=0.02, long_side=96, batch=2, threads=1)
    model = train([data_set], out, settings)
    step = read_state(out / "last.pt")["step"]
    assert step > 0
    for name in ("validation.csv", "training.csv", "curves.png", "skin_int8.onnx"):
        assert (out / name).is_file()
    longer = replace(settings, minutes=0.04)
    assert train([data_set], out, longer, resume=out / "last.pt") == model
    assert read_state(out / "last.pt")["step"] > step
    assert model.stat().st_size < 15e6
    names = {region.name for region in load(model).detect(np.zeros((64, 64, 3), np.uint8))}
    assert names <= set(SKIN_CLASSES)
    papers = replace(settings, freeze_until=0.5, optimiser="sgd", decay=0.01)
    train([data_set], tmp_path / "fine", papers, weights=model)
    longer = replace(settings, minutes=0.03)
    train([data_set], tmp_path / "fine", longer, resume=tmp_path / "fine" / "last.pt")
    state = read_state(tmp_path / "fine" / "last.pt")
    assert state["step"] > 0
    assert (optimiser_of(state), state["freeze_until"]) == ("sgd", 0.5)
    assert [group["weight_decay"] for group in state["optimiser"]["param_groups"]] == [0.01, 0.0]


@pytest.fixture
def exported(tmp_path):
    """A network with lively norms, and its ONNX file."""
    torch.manual_seed(1)
    model = Yolov5s(6, ANCHORS)
    for module in model.modules():
        if isinstance(module, torch.nn.BatchNorm2d):
            torch.nn.init.uniform_(module.weight, 0.5, 1.5)
            torch.nn.init.normal_(module.bias, std=0.2)
            torch.nn.init.uniform_(module.running_var, 0.5, 1.5)
    run = Run(model, Average(model), make_optimiser(model, TrainSettings()), 64)
    save_run(tmp_path / "net.pt", run)
    export(tmp_path / "net.pt", tmp_path / "net.onnx", size=64)
    return model.eval(), tmp_path / "net.onnx"


def test_a_network_from_its_file_gives_the_same_numbers_and_can_learn(exported):
    model, file = exported
    pictures = torch.rand(4, 3, 64, 96)
    again, size = network_from_onnx(file, pictures)
    assert size == 64
    assert torch.equal(again.anchors, model.anchors)
    with torch.no_grad():
        for ours, theirs in zip(again.eval()(pictures), model(pictures), strict=True):
            torch.testing.assert_close(ours, theirs, rtol=0.02, atol=0.05)
        for ours, theirs in zip(again.train()(pictures), model(pictures), strict=True):
            torch.testing.assert_close(ours, theirs, rtol=0.02, atol=0.05)


def test_anchors_grow_with_the_pictures(exported, data_set, tmp_path):
    model, file = exported
    sources = [load_source(data_set, list_samples(data_set), 128)]
    settings = TrainSettings(long_side=128, batch=2, threads=1)
    for weights in (file, tmp_path / "net.pt"):
        run = start_run(sources, settings, None, weights)
        assert run.size == 128
        for network in (run.model, run.average.model):
            torch.testing.assert_close(network.anchors, 2.0 * model.anchors)
    save_run(tmp_path / "larger.pt", run)
    again = start_run(sources, replace(settings, long_side=192), tmp_path / "larger.pt")
    assert again.size == 192
    torch.testing.assert_close(again.model.anchors, 3.0 * model.anchors)


def test_a_file_that_is_no_float_model_of_ours_cannot_begin_a_run(tmp_path):
    (tmp_path / "a.onnx").write_text("no")
    with pytest.raises(ModelError, match="cannot train on"):
        network_from_onnx(tmp_path / "a.onnx", torch.rand(1, 3, 64, 64))


def test_a_gradient_that_is_no_number_changes_nothing_and_ends_the_run_in_time():
    torch.manual_seed(0)
    model = Yolov5s(6, ANCHORS)
    run = Run(model, Average(model), make_optimiser(model, TrainSettings()), 64)
    before = {name: value.clone() for name, value in run.average.model.state_dict().items()}
    gradient = ParallelGradient(model, 1)
    batch = Batch(torch.full((2, 3, 96, 96), float("nan")), torch.tensor([[0, 4, 20.0, 20.0, 30.0, 20.0]]))
    for _ in range(20):
        train_step(run, gradient, batch, 1e-3, frozen=False)
    with pytest.raises(TrainingError, match="no number in 21 steps"):
        train_step(run, gradient, batch, 1e-3, frozen=False)
    gradient.close()
    assert all(torch.isfinite(buffer).all() for buffer in run.model.buffers())
    assert all(torch.equal(value, before[name]) for name, value in run.average.model.state_dict().items())


def test_a_file_that_is_no_checkpoint_is_refused(tmp_path):
    (tmp_path / "a.pt").write_text("no")
    with pytest.raises(ModelError, match="as a checkpoint"):
        read_state(tmp_path / "a.pt")
