"""Run the programs of a model: the module in Python, and the header compiled by the machine's compiler."""

import shutil
import subprocess
import types

import numpy as np
import pandas as pd
import pytest

from imugap import log
from imugap.interchange.code.program import Language, program

FLAGS = ("-std=c++17", "-O1", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off")
MAIN = """
#include "imu.hpp"
#include <cstdio>
static void print(const imugap::Sample& s) {
  std::printf("%.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %d\\n", s.time, s.rate[0], s.rate[1], s.rate[2],
              s.force[0], s.force[1], s.force[2], s.temperature, static_cast<int>(s.lost));
}
int main() {
  imugap::Imu imu(SEED);
  double t, wx, wy, wz, fx, fy, fz, c;
  while (std::scanf("%lf %lf %lf %lf %lf %lf %lf %lf", &t, &wx, &wy, &wz, &fx, &fy, &fz, &c) == 8) {
    const auto sample = imu.step(t, {fx, fy, fz}, {wx, wy, wz}, c);
    if (sample) print(*sample);
  }
  for (const auto& sample : imu.finish()) print(sample);
}
"""
NAMES = (log.TIME, *log.AXES, log.TEMPERATURE, "lost")


def module(model, rate):
    """The program in Python, as a module."""
    made = types.ModuleType("imu")
    exec(compile(program(model, Language.PYTHON, rate), "imu.py", "exec"), made.__dict__)
    return made


def rows_of(ideal):
    """Time, angular rate, specific force and temperature of each row of an error-free log; zero where it has none."""
    columns = [ideal[name].to_numpy(float) if name in ideal else np.zeros(len(ideal)) for name in log.COLUMNS]
    return np.column_stack([ideal.index.to_numpy(float), *columns])


def run(model, rate, ideal, seed):
    """What the program in Python makes of an error-free log: a table with a column ``lost``."""
    imu = module(model, rate).Imu(seed)
    found = [imu.step(row[0], row[4:7], row[1:4], row[7]) for row in rows_of(ideal)]
    samples = [one for one in found if one is not None] + imu.finish()
    return pd.DataFrame([(s.time, *s.rate, *s.force, s.temperature, s.lost) for s in samples], columns=NAMES)


def run_cpp(model, rate, ideal, seed, folder):
    """The same from the header; skips a test where the machine has no compiler."""
    compiler = shutil.which("g++")
    if compiler is None:
        pytest.skip("no g++ on this machine")
    (folder / "imu.hpp").write_text(program(model, Language.CPP, rate))
    (folder / "main.cpp").write_text(MAIN.replace("SEED", str(seed)))
    subprocess.run([compiler, *FLAGS, folder / "main.cpp", "-o", folder / "imu"], check=True)
    lines = "\n".join(" ".join(map(repr, row)) for row in rows_of(ideal).tolist())
    text = subprocess.run([folder / "imu"], input=lines, capture_output=True, text=True, check=True).stdout
    return pd.DataFrame([map(float, line.split()) for line in text.splitlines()], columns=NAMES)


def moving(rate, count, scale=1.0):
    """An error-free log in smooth motion, with a temperature."""
    time = np.arange(count) / rate
    columns = {
        name: scale * (0.3 * (k % 3) + np.sin((1.1 + 0.7 * k) * time + k) + 0.4 * np.cos(9.7 * time * (1 + 0.1 * k)))
        for k, name in enumerate(log.AXES)
    }
    return log.from_samples({**columns, log.TEMPERATURE: 25 + 5 * np.sin(0.4 * time)}, 1 / rate)


def at_rest(rate, count):
    """An error-free log of zeros."""
    return log.from_samples(
        {**dict.fromkeys(log.AXES, np.zeros(count)), log.TEMPERATURE: np.full(count, 25.0)}, 1 / rate
    )
