"""tools/materials.inc and the page Howto_defe_materials.rst: fix defe takes all presets, interlayers have the moduli that are
published, and the page says what the file has.

DEFE_LMP, DEFE_PLUGIN: the lmp program and defeplugin.so (ctest sets them)."""

import functools
import math
import os
import re
import subprocess
import tempfile
import unittest
from pathlib import Path

SOURCE = Path(__file__).resolve().parent.parent.parent
FILE = SOURCE / "tools/materials.inc"
PAGE = SOURCE / "lammps-package/doc/Howto_defe_materials.rst"

NAMES = re.findall(r"(?m)^variable (\w+) +string", FILE.read_text())
ENDS = ("_convert", "_joint", "_adhesive", "_surface", "_rate")
MATERIALS = [name for name in NAMES if not name.endswith(ENDS)]

# Shear moduli in MPa by temperature, after 1 s, 3 s, a minute, an hour, a day: Engineering Structural Glass Design Guide (NCSEA).
HOUR, DAY = 3600.0, 86400.0
IONOMER = {10: (240, 236, 225, 206), 20: (217, 211, 195, 169), 24: (200, 193, 173, 142), 30: (151, 141, 110, 59.9),
           40: (77.0, 63.0, 30.7, 9.28), 50: (36.2, 26.4, 11.3, 4.20)}
PVB = {20: (8.060, 1.640, 0.840, 0.508), 30: (0.971, 0.753, 0.441, 0.281), 40: (0.610, 0.455, 0.234), 50: (0.440, 0.290, 0.052)}
# Young's moduli in MPa of structural PVB by temperature, after 3 s, a minute, an hour, 30 days, a year: what the preset is fitted to.
STRUCTURAL = {10: (699, 573, 388, 80, 19), 20: (342, 196, 37, 1.9, 1.6), 30: (58, 9.2, 2, 1.5, 1.5), 40: (3.4, 1.8, 1.6, 1.5),
              50: (1.7, 1.6), 60: (1.6, 1.5)}


def lammps(script, *options):
    plugin = Path(os.environ["DEFE_PLUGIN"])
    variables = dict(os.environ, LD_LIBRARY_PATH=f"{plugin.parent}:{os.environ.get('LD_LIBRARY_PATH', '')}")
    with tempfile.TemporaryDirectory(prefix="defe-materials-") as folder:
        (Path(folder) / "in.test").write_text(script)
        return subprocess.run([SOURCE / "tools/mpirun.sh", "1", os.environ["DEFE_LMP"], "-in", "in.test", "-log", "none", "-nocite",
                               *options], cwd=folder, env=variables, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True)


TEMPERATURES = (-20, 0, 10, 20, 23, 24, 30, 40, 50, 60)


@functools.cache
def all_words():
    """By temperature and variable, None for the temperature that the file has by itself: what the variables say."""
    prints = "".join(f'print "value {name} ${{{name}}}"\n' for name in NAMES)
    script = "print 'at None'\n"
    for temperature in TEMPERATURES:
        script += f"include {FILE}\n{prints}variable temperature delete\nvariable temperature index {temperature}\nprint 'at {temperature}'\n"
    run = lammps(script + f"include {FILE}\n{prints}")
    assert run.returncode == 0, run.stdout
    found = {}
    for line in run.stdout.splitlines():
        what, *rest = line.split() or [""]
        if what == "at":
            now = found.setdefault(None if rest[0] == "None" else int(rest[0]), {})
        elif what == "value":
            now[rest[0]] = rest[1:]
    return found


def words(temperature=None):
    return all_words()[temperature]


def modulus(prony, time):
    """Shear modulus in MPa, of the words of a Prony series."""
    assert prony[0] == "prony"
    numbers = [float(w) for w in prony[1:]]
    terms = numbers[4:]
    assert len(terms) == 2 * numbers[3]
    return 1e-6 * (numbers[2] + sum(G * math.exp(-min(beta * time, 700.0)) for G, beta in zip(terms[::2], terms[1::2])))


class Materials(unittest.TestCase):
    def test_fix_defe_takes_all_of_them_in_one_script(self):
        materials, coeffs, meshes = "", "pair_coeff * * cohesive 1e6 1 0.1 contact 0.9 0.2\n", ""
        for k, name in enumerate(MATERIALS):
            materials += f" material {name} ${{{name}}}"
            if name + "_convert" in NAMES:
                materials += f" convert {name} ${{{name}_convert}} type {k + 1} group particles"
                coeffs += f"pair_coeff {k + 1} {k + 1} connective material ${{{name}_joint}} contact 0.9 0.2\n"
            meshes += f"create_hexes fe {name} {len(MATERIALS) + 1} x 0 1 0.001 y 0 1 0.001 z {0.002 * k:g} 1 {0.002 * k + 0.001:g}\n"
        script = f"""
units si
atom_style sphere
newton off on
comm_modify vel yes
include {FILE}
plugin load defeplugin.so
region box block -0.01 0.01 -0.01 0.01 -0.01 0.1
create_box {len(MATERIALS) + 1} box
pair_style defe/joint
{coeffs}group particles empty
fix fe all defe {materials} adhesive glass_float pvb ${{pvb_adhesive}}
{meshes}group nodes type {len(MATERIALS) + 1}
fix move1 nodes nve
fix move2 particles nve/sphere
neighbor 0.0002 bin
timestep 2e-8
velocity all create 0 1
velocity all ramp vx 0 1 x 0 0.001
run 20
print "energy $(f_fe[9])"
"""
        for temperature in (-20, 0, 23, 50):
            run = lammps(script, "-var", "temperature", str(temperature))
            self.assertEqual(run.returncode, 0, run.stdout[-3000:])
            energy = re.search(r"(?m)^energy (\S+)", run.stdout)
            self.assertGreater(float(energy[1]), 0.0)

    def test_pvb_has_the_published_moduli(self):
        for temperature, moduli in PVB.items():
            prony = words(temperature)["pvb"]
            for time, G in zip((3.0, 60.0, HOUR, DAY), moduli):
                self.assertAlmostEqual(modulus(prony, time) / G, 1.0, delta=0.02, msg=f"{temperature} C, {time} s")

    def test_ionomer_has_the_published_moduli(self):
        squares = []
        for temperature, moduli in IONOMER.items():
            prony = words(temperature)["ionomer"]
            for time, G in zip((1.0, 3.0, 60.0, HOUR), moduli):
                squares.append((modulus(prony, time) / G - 1.0)**2)
        self.assertLess(max(squares), 0.221**2)
        self.assertLess(sum(squares) / len(squares), 0.09**2)

    def test_structural_pvb_has_the_moduli_that_it_is_fitted_to(self):
        squares = []
        for temperature, moduli in STRUCTURAL.items():
            prony = words(temperature)["pvb_structural"]
            for time, E in zip((3.0, 60.0, HOUR, 30 * DAY, 365 * DAY), moduli):
                squares.append((3.0 * modulus(prony, time) / E - 1.0)**2)
        self.assertEqual(len(squares), 23)
        self.assertLess(max(squares), 0.04**2)
        self.assertLess(sum(squares) / len(squares), 0.022**2)

    def test_the_shift_is_that_of_williams_landel_and_ferry(self):
        shifts = {"pvb": (20.7, 91.1), "pvb_structural": (29.0, 95.0), "ionomer": (27.0, 80.0), "eva": (339.102, 1185.816)}
        at_20 = {name: words(20)[name] for name in shifts}
        for temperature in (-20, 0, 23, 50):
            now = words(temperature)
            for name, (C1, C2) in shifts.items():
                shift = 10.0**(-C1 * (temperature - 20.0) / (C2 + temperature - 20.0))
                for time in (1e-4, 1.0):
                    expected = modulus(at_20[name], time / shift)
                    self.assertAlmostEqual(modulus(now[name], time) / expected, 1.0, delta=1e-6)

    def test_eva_has_the_moduli_of_its_series(self):
        # relaxation times of 1e-9 to 1e12 s at 20 C, moduli in kPa, and what never relaxes
        G = (6933.9, 3898.6, 2289.2, 1672.7, 761.6, 2401.0, 65.2, 248.0, 575.6, 56.3, 188.6, 445.1, 300.1, 401.6, 348.1, 111.6,
             127.2, 137.8, 50.5, 322.9, 100.0, 199.9)
        for time in (1e-8, 1e-4, 1.0, HOUR, DAY):
            series = 682.18 + sum(g * math.exp(-min(time / 10.0**(k - 9), 700.0)) for k, g in enumerate(G))
            self.assertAlmostEqual(modulus(words(20)["eva"], time) / (1e-3 * series), 1.0, delta=1e-6, msg=f"{time} s")

    def test_eva_and_pvb_differ_as_their_paper_says(self):
        # EVA softer at first, with less decay, stiffer after long
        pvb, eva = (words(23)[name] for name in ("pvb", "eva"))
        self.assertGreater(modulus(pvb, 1e-6), modulus(eva, 1e-6))
        self.assertGreater(modulus(eva, 30 * DAY), modulus(pvb, 30 * DAY))

    def test_the_table_of_the_page_has_the_moduli_of_the_file(self):
        text = PAGE.read_text()
        table = text[text.index("- Temperature (C)"):text.index("The series of PVB")]
        for temperature in (-20, 0, 23, 50):
            row = re.search(rf"\* - {temperature}\n((?:     - \S+\n)+)", table)[1].replace("-", " ").split()
            printed = [float(w) for w in row]
            series = [modulus(words(temperature)[name], time) for name in ("pvb", "pvb_structural", "ionomer", "eva") for time in (1e-4, 1.0)]
            for a, b in zip(printed, series, strict=True):
                self.assertAlmostEqual(a / b, 1.0, delta=0.02, msg=f"{temperature} C")

    def test_it_is_23_degrees_if_nothing_is_said(self):
        self.assertEqual(words(), words(23))
        self.assertNotEqual(words(), words(24))

    def test_temperatures_without_figures_are_refused(self):
        for temperature in (-31, 296):
            run = lammps(f"include {FILE}\n", "-var", "temperature", str(temperature))
            self.assertNotEqual(run.returncode, 0)
            self.assertIn("the temperature of interlayers must be from -30 to 60 degrees C, not", run.stdout)

    def test_the_page_has_all_of_them_with_their_numbers(self):
        text = PAGE.read_text()
        for name, value in words().items():
            self.assertIn(f"*{name}*" if name in MATERIALS else f"_{name.rsplit('_', 1)[1]}", text)
            if value[0] == "prony":
                value = value[:4]
            self.assertIn(" ".join(value), text, name)

    def test_fracture_energies_are_those_of_the_toughness(self):
        value = words()
        for name, toughness in (("glass_borosilicate", 0.8e6), ("alumina", 4e6), ("pmma", 1.207e6)):
            E, nu = (float(w) for w in value[name][1:3])
            self.assertAlmostEqual(float(value[name + "_joint"][2]) * E / (toughness**2 * (1.0 - nu**2)), 1.0, delta=0.01, msg=name)

    def test_concretes_are_those_of_the_model_code(self):
        value = words()
        for fck in (30.0, 50.0, 120.0):
            fcm = fck + 8.0
            name = f"concrete_c{fck:.0f}"
            fctm = 0.3 * fck**(2.0 / 3.0) if fck <= 50.0 else 2.12 * math.log(1.0 + 0.1 * fcm)
            for word, expected in ((value[name][1], 21.5e9 * (fcm / 10.0)**(1.0 / 3.0)), (value[name + "_convert"][0], 1e6 * fctm),
                                   (value[name + "_joint"][1], 1e6 * fctm), (value[name + "_joint"][2], 73.0 * fcm**0.18)):
                self.assertAlmostEqual(float(word) / expected, 1.0, delta=0.005, msg=name)

    def test_uhpc_is_within_what_is_printed(self):
        value = words()
        self.assertTrue(50e9 <= float(value["concrete_uhpc"][1]) <= 75e9)
        self.assertEqual(float(value["concrete_uhpc_convert"][0]), 10e6)
        self.assertEqual(value["concrete_uhpc_joint"][1], value["concrete_uhpc_convert"][0])
        self.assertEqual(float(value["concrete_uhpc_joint"][2]), 0.5 * 40000.0)


if __name__ == "__main__":
    unittest.main(verbosity=2)
