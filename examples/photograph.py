"""Makes the photograph that other examples look at: an arena from above, as a camera shows it.

    python examples/photograph.py [FOLDER]

Dark obstacles on a light floor, 640 x 480 pixels, with uneven light, blur and noise.
"""

import sys
from pathlib import Path

import cv2
import numpy as np


def photograph(seed: int = 1) -> np.ndarray:
    """(480, 640) uint8."""
    large = np.full((1920, 2560), 205, np.uint8)
    cv2.circle(large, (1150, 640), 260, 55, -1)
    cv2.fillPoly(large, [np.array([(420, 900), (900, 1020), (760, 1480), (380, 1380)])], 60)
    cv2.fillPoly(large, [np.array([(1560, 1000), (2140, 900), (2220, 1120), (1640, 1260)])], 50)
    cv2.fillPoly(large, [np.array([(1220, 1420), (1500, 1560), (1160, 1760)])], 58)
    cv2.fillPoly(large, [np.array([(1800, 180), (2160, 260), (2000, 560)])], 52)
    picture = cv2.resize(large, (640, 480), interpolation=cv2.INTER_AREA).astype(np.float64)
    rows, columns = np.mgrid[0:480, 0:640]
    light = 1.0 - 0.18 * np.hypot(columns - 250, rows - 200) / 400
    picture = cv2.GaussianBlur(picture * light, (0, 0), 0.8)
    picture += np.random.default_rng(seed).normal(0.0, 3.0, picture.shape)
    return np.clip(picture, 0, 255).astype(np.uint8)


def main(folder: Path) -> None:
    """Write photograph.png."""
    cv2.imwrite(str(folder / "photograph.png"), photograph())
    print(f"wrote {folder / 'photograph.png'}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
