"""Image PSNR: planted differences, and an independent implementation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from skimage.metrics import peak_signal_noise_ratio

from meshmark.errors import InputError
from meshmark.metrics.image import image_psnr_db


def test_planted_differences():
    black = np.zeros((4, 4), np.uint8)
    assert image_psnr_db(black, black) == math.inf
    assert image_psnr_db(black, black + np.uint8(255)) == 0.0
    assert image_psnr_db(black / 1.0, black + 0.1) == pytest.approx(20.0)
    assert image_psnr_db(black > 0, black == 0) == 0.0


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float64])
def test_as_scikit_image_has_it(dtype):
    random = np.random.default_rng(0)
    images = (
        random.integers(0, 255, (2, 9, 7, 3)).astype(dtype)
        if dtype != np.float64
        else random.random((2, 9, 7))
    )
    expected = peak_signal_noise_ratio(
        *images, data_range=np.iinfo(dtype).max if dtype != np.float64 else 1.0
    )
    assert image_psnr_db(*images) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(
    "pair",
    [(np.zeros(3), np.zeros(4)), (np.zeros(3), np.zeros(3, np.uint8)), (np.zeros(0), np.zeros(0)),
     (np.zeros(2, complex), np.zeros(2, complex))],
)  # fmt: skip
def test_what_cannot_be_compared_is_refused(pair):
    with pytest.raises(InputError):
        image_psnr_db(*pair)
