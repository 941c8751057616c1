"""What the paper reports, as it is printed there, and what is doubtful about it (docs/design.md, section 9).

Modigari Narendra, Valarmathi, Jani Anbarasi, Gandomi: Levenberg-Marquardt deep neural watermarking for 3D mesh
using nearest centroid salient point learning.
"""

from __future__ import annotations

from dataclasses import dataclass

__all__ = [
    "ABLATION",
    "CLAIMED",
    "CLASSES",
    "DOUBTS",
    "FIGURES",
    "TABLES",
    "Ablated",
    "Claims",
]

# The paper's columns, and the names of these schemes here.
CLAIMED = {
    "ncdg_lv": "NCDG-LV",
    "laplace_beltrami": "Laplace–Beltrami",
    "mdaqim": "3D-MDAQIM",
    "deep3d": "Deep 3D mesh",
}
# Models 1 to 10, in the order in which the text lists them: that the tables have this order is our reading.
CLASSES = ("rabbit", "vase", "bee", "face", "horse", "table", "bird", "spider", "ant", "dog")


@dataclass(frozen=True, kw_only=True)
class Claims:
    """A table of the paper: a row of `CLAIMED` values for each of `CLASSES`, and the average where it has one."""

    name: str
    about: str
    unit: str
    rows: tuple[tuple[float, float, float, float], ...]
    average: tuple[float, float, float, float] | None = None


TABLES = {
    1: Claims(
        name="Table 1",
        about="PSNR of the marked model",
        unit="dB",
        rows=(
            (56.08, 54.15, 51.22, 55.48),
            (58.58, 56.08, 52.56, 57.56),
            (52.56, 46.54, 45.20, 50.02),
            (58.58, 54.15, 51.22, 56.43),
            (54.15, 52.56, 50.06, 53.56),
            (56.08, 54.15, 51.22, 55.11),
            (51.22, 49.04, 47.30, 50.02),
            (56.08, 54.15, 52.56, 55.22),
            (52.56, 51.22, 50.06, 51.87),
            (54.13, 53.12, 52.18, 48.23),
        ),
    ),
    2: Claims(
        name="Table 2",
        about="bit errors",
        unit="%",
        rows=(
            (2.15, 3.25, 4.00, 2.85),
            (2.35, 3.85, 4.15, 3.15),
            (3.15, 3.95, 4.35, 3.65),
            (3.85, 4.15, 4.85, 4.05),
            (4.15, 5.00, 5.15, 4.65),
            (5.35, 5.65, 5.25, 5.45),
            (6.25, 7.00, 8.15, 6.85),
            (8.00, 7.35, 8.35, 7.75),
            (9.15, 8.00, 9.25, 8.45),
            (12.00, 8.25, 12.55, 11.0),
        ),
        average=(5.64, 5.645, 6.605, 5.785),
    ),
    3: Claims(
        name="Table 3",
        about="bit errors with smoothing",
        unit="%",
        rows=(
            (3.25, 3.85, 4.15, 3.55),
            (3.85, 4.25, 4.55, 4.05),
            (3.55, 4.55, 4.65, 3.75),
            (4.35, 4.85, 5.35, 4.65),
            (5.35, 6.15, 7.25, 5.85),
            (7.25, 8.35, 9.00, 7.85),
            (8.55, 9.00, 10.35, 8.75),
            (10.35, 11.55, 12.00, 11.0),
            (15.00, 17.35, 19.15, 16.55),
            (16.35, 18.00, 20.0, 17.45),
        ),
        average=(7.785, 8.79, 9.645, 8.345),
    ),
    4: Claims(
        name="Table 4",
        about="PSNR with 1, 2 and 5 % noise",
        unit="dB",
        rows=(
            (51.05, 49.12, 46.19, 50.38),
            (53.55, 51.05, 47.53, 52.46),
            (47.53, 41.51, 40.17, 45.58),
            (53.55, 49.13, 46.19, 51.45),
            (49.12, 47.53, 45.03, 48.55),
            (51.05, 49.12, 46.19, 49.68),
            (46.19, 44.01, 41.27, 45.52),
            (51.05, 49.13, 47.53, 50.22),
            (47.53, 46.19, 45.03, 46.88),
            (51.05, 49.13, 47.53, 49.95),
        ),
    ),
}


@dataclass(frozen=True, kw_only=True)
class Ablated:
    """A row of the ablation table: the modules in the paper's words, and its PSNR of training and test set, dB."""

    modules: str
    train: float
    test: float


ABLATION = (
    Ablated(modules="Vertices + clustering + MF_B + LM_DN", train=22.68, test=25.84),
    Ablated(modules="NC_DGG + Fuzzy clustering + LSB + LM_DN", train=42.45, test=40.12),
    Ablated(modules="NC_DGG + MS + LSB + LM_DN", train=52.25, test=48.12),
    Ablated(modules="NC–DGG + MS + MF_B + LM_DN", train=58.12, test=54.13),
)

# What the text says of the figures, in the order of `CLAIMED`; their curves are drawn only.
FIGURES = {
    7: ("salient point detection time of the first run, ms", (7.75, 9.25, 10.25, 8.15)),
    9: ("distortion rate of 50 models", (1.2, 1.6, 2.0, 1.4)),
    10: ("true positive rate, %", (90.0, 88.0, 84.0, 89.0)),
}

_ALL = (
    "The paper states no payload and no budget of distortion; its rivals are not re-run at equal ones. "
    "Models 1 to 10 are taken in the order in which the text lists them."
)
DOUBTS = {
    "Table 1": f"{_ALL} Its equation 17 lacks the square of Max: the value depends on the unit of the model.",
    "Table 2": (
        f"{_ALL} The averages 5.64 and 5.645 are a tie. Of models 8 to 10 the paper's own rows have "
        "Laplace–Beltrami ahead. “Training” and “testing” errors in the text are those of tables 3 and 2: "
        "with and without smoothing."
    ),
    "Table 3": f"{_ALL} Ten passes of smoothing; with which factor is not said.",
    "Table 4": (
        "The paper gives one value for three strengths of noise. It equals Table 1 minus 5.02 to 5.03 dB "
        f"in 26 of 27 cells of the first three methods and models 1 to 9, whatever the model. {_ALL}"
    ),
    "Figure 7": (
        "3D-MDAQIM and the deep network have no salient points, and the paper still gives a time of theirs "
        "for finding them. Its machine is another one than this."
    ),
    "Figure 9": (
        "A rate of missed detections is 0 to 1; 1.2 can only be per cent. That it grows with the number of "
        "models is no property of a rate."
    ),
    "Figure 10": "A true positive rate says nothing without the false positive rate, which is not given.",
    "Figure 11": "Drawn only. Of which picture or payload the PSNR is that of the watermark is not said.",
    "Figure 12": "Drawn only. Of which picture or payload the PSNR is that of the watermark is not said.",
    "Figure 13": "Drawn only. Of which picture or payload the PSNR is that of the watermark is not said.",
    "Ablation": (
        "The paper's rows swap several modules at once and give one PSNR, without a payload. Learning rate "
        "0.01 in the text, 0.1 in the algorithm; Levenberg–Marquardt has none."
    ),
}
