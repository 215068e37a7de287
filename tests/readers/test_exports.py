"""Every export, read back by its own community's reader and compared, value by value, with the CSV export of the same run.

Called by tools/test-readers.sh with the folder that holds the exports: csv/, run.gsd, run.xyz, run.npz, vtk/, run.mcap.
"""

import csv
import json
import sys
import unittest
from pathlib import Path

import numpy as np

FOLDER = Path(sys.argv.pop())


def table(name):
    """Columns of a table by name without unit, texts where they are no numbers."""
    with open(FOLDER / "csv" / name, newline="") as file:
        rows = list(csv.reader(file))
    columns = {}
    for title, values in zip(rows[0], zip(*rows[1:])):
        name = title.split(" [")[0]
        columns[name] = np.array(values) if name == "species" else np.array(values, dtype="f8")
    return columns


def vectors(columns, prefix, names="xyz"):
    return np.stack([columns[prefix + c] for c in names], axis=-1)


class Exports(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        squirmers = table("squirmers.csv")
        cls.steps = np.unique(squirmers["step"])
        shape = (len(cls.steps), -1)
        cls.names = squirmers["species"].reshape(shape)
        pick = lambda *arguments: vectors(squirmers, *arguments).reshape(len(cls.steps), -1, len((arguments + ("xyz",))[1]))
        cls.position, cls.velocity, cls.axis = pick(""), pick("v"), pick("e")
        cls.unwrapped, cls.omega, cls.force = pick("unwrapped_"), pick("omega_"), pick("force_")
        cls.quaternion = pick("q", "xyzw")
        cls.time = squirmers["time"].reshape(shape)[:, 0]
        cls.scalars = table("scalars.csv")
        cls.fields = table("fields.csv")
        cls.box = np.array(json.loads((FOLDER / "info.json").read_text())["box_size"])

    def same(self, found, wanted, kind="f4"):
        """Equal in every bit of the recorded numbers."""
        np.testing.assert_array_equal(np.asarray(found, dtype=kind), np.asarray(wanted, dtype=kind))

    def test_there_is_something_to_compare(self):
        self.assertGreater(len(self.steps), 3)
        self.assertEqual(self.position.shape[1], 3)
        self.assertEqual(set(self.names[0]), {"long", "flat"})
        self.assertGreater(np.abs(self.velocity).min(), 0)

    def test_gsd(self):
        import gsd.hoomd

        with gsd.hoomd.open(FOLDER / "run.gsd", "r") as file:
            self.assertEqual(len(file), len(self.steps))
            for i, frame in enumerate(file):
                p = frame.particles
                self.assertEqual(frame.configuration.step, self.steps[i])
                self.same(frame.configuration.box, [*self.box, 0, 0, 0])
                self.assertEqual([p.types[t] for t in p.typeid], list(self.names[i]))
                self.same(p.position, np.float32(self.position[i]).astype("f8") - self.box / 2)
                self.same(p.velocity, self.velocity[i])
                self.same(p.orientation, np.roll(self.quaternion[i], 1, axis=1))
                np.testing.assert_allclose(p.position + self.box / 2 + p.image * self.box, self.unwrapped[i], atol=1e-5)
                self.same(frame.log["particles/angular_velocity"], self.omega[i])
                self.same(frame.log["particles/force"], self.force[i])
                self.assertEqual(frame.log["time"][0], self.time[i])
                self.assertEqual(frame.log["temperature"][0], self.scalars["temperature"][i])
                shapes = {name: shape for name, shape in zip(p.types, p.type_shapes)}
                self.assertEqual(shapes["long"], {"type": "Ellipsoid", "a": 1.0, "b": 1.0, "c": 2.0})
                self.assertEqual(shapes["flat"], {"type": "Ellipsoid", "a": 1.5, "b": 1.5, "c": 0.5})
                volume = {"long": 2.0, "flat": 0.5 * 1.5**2}
                np.testing.assert_allclose(p.diameter, [2 * volume[n] ** (1 / 3) for n in self.names[i]], rtol=1e-6)
        self.assertGreater(np.abs(self.unwrapped - self.position).max(), 1, "no squirmer has crossed the box")

    def test_xyz(self):
        import ase.io

        frames = ase.io.read(FOLDER / "run.xyz", index=":", format="extxyz")
        self.assertEqual(len(frames), len(self.steps))
        for i, atoms in enumerate(frames):
            self.assertEqual((atoms.info["Step"], atoms.info["Time"]), (self.steps[i], self.time[i]))
            self.assertEqual(atoms.info["temperature"], self.scalars["temperature"][i])
            self.same(atoms.cell.array, np.diag(self.box), "f8")
            self.assertEqual(list(atoms.pbc), [True, True, True])
            self.assertEqual(set(atoms.symbols), {"X"})
            self.same(atoms.positions, self.position[i])
            self.same(atoms.arrays["velo"], self.velocity[i])
            self.same(atoms.arrays["orientation"], self.quaternion[i])
            self.same(atoms.arrays["omega"], self.omega[i])
            self.same(atoms.arrays["id"], [0, 1, 2], "i4")
            shapes = {"long": [1, 1, 2], "flat": [1.5, 1.5, 0.5]}
            self.same(atoms.arrays["aspherical_shape"], [shapes[n] for n in self.names[i]], "f8")

    def test_npz(self):
        with np.load(FOLDER / "run.npz") as file:
            self.same(file["squirmers.step"], self.steps, "u8")
            self.same(file["squirmers.time"], self.time, "f8")
            self.same(file["squirmers.position"], self.position)
            self.same(file["squirmers.unwrapped"], self.unwrapped, "f8")
            self.same(file["squirmers.orientation"], self.quaternion)
            self.assertEqual(file["squirmers.position"].dtype, np.float32)
            self.assertEqual(list(file["squirmers.species.name"]), [b"long", b"flat"])
            self.same(file["squirmers.species.semi_axes"], [[2, 1], [0.5, 1.5]], "f8")
            self.same(file["scalars.temperature"], self.scalars["temperature"], "f8")
            frames = len(file["fields.step"])
            self.same(file["fields.density"], self.fields["density"].reshape(frames, -1))
            self.same(file["fields.velocity"], vectors(self.fields, "v").reshape(frames, -1, 3))
            self.same(file["fields.box"], self.box, "f8")
            units = dict(file["units"].tolist())
            self.assertEqual(units[b"squirmers.velocity"], b"sqrt(kT/m)")

    def test_vtk(self):
        from xml.etree import ElementTree

        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkIOXML import vtkXMLImageDataReader, vtkXMLPolyDataReader

        def listed(name):
            for entry in ElementTree.parse(FOLDER / "vtk" / name).iter("DataSet"):
                yield float(entry.get("timestep")), str(FOLDER / "vtk" / entry.get("file"))

        def read(reader, file):
            reader.SetFileName(file)
            reader.Update()
            self.assertEqual(reader.GetErrorCode(), 0)
            return reader.GetOutput()

        times = self.fields["time"]
        fields = list(listed("fields.pvd"))
        self.assertEqual([time for time, _ in fields], sorted(set(times)))
        for time, file in fields:
            image = read(vtkXMLImageDataReader(), file)
            here, cells = times == time, image.GetCellData()
            density = vtk_to_numpy(cells.GetArray("density"))
            self.same(density, self.fields["density"][here])
            self.same(vtk_to_numpy(cells.GetArray("velocity")), vectors(self.fields, "v")[here])
            self.assertEqual(image.GetBounds(), (0.0, self.box[0], 0.0, self.box[1], 0.0, self.box[2]))
            for i in (0, 1, len(density) // 2, len(density) - 1):
                bounds = np.array(image.GetCell(i).GetBounds()).reshape(3, 2)
                self.same(bounds.mean(axis=1), vectors(self.fields, "")[here][i], "f8")
        squirmers = list(listed("squirmers.pvd"))
        self.assertEqual([time for time, _ in squirmers], list(self.time))
        for i, (_, file) in enumerate(squirmers):
            points = read(vtkXMLPolyDataReader(), file)
            data = points.GetPointData()
            self.same(vtk_to_numpy(points.GetPoints().GetData()), self.position[i])
            self.same(vtk_to_numpy(data.GetArray("axis")), self.axis[i])
            self.same(vtk_to_numpy(data.GetArray("velocity")), self.velocity[i])
            self.same(vtk_to_numpy(data.GetArray("quaternion_wxyz")), np.roll(self.quaternion[i], 1, axis=1))
            self.assertEqual(points.GetNumberOfVerts(), 3)

    def test_mcap(self):
        """The recording itself, by the reader in docs/format.md."""
        from mcap.reader import make_reader

        text = (Path(__file__).parents[2] / "docs" / "format.md").read_text()
        code = text.split("## Reading without squirm")[1].split("    with open")[0]
        names = {}
        exec("\n".join(line[4:] for line in code.splitlines()), names)
        with open(FOLDER / "run.mcap", "rb") as file:
            reader = make_reader(file, validate_crcs=True)
            messages = [m.data for _, _, m in reader.iter_messages(topics=["/squirm/squirmers"])]
            attached = [a.name for a in reader.iter_attachments()]
        self.assertEqual(attached, ["pipeline.toml", "provenance.json"])
        columns = [dict(names["columns"](m)) for m in messages]
        self.same(np.array([c["position"] for c in columns]), self.position)
        self.same(np.array([c["orientation"] for c in columns]), self.quaternion)


if __name__ == "__main__":
    unittest.main(verbosity=2)
