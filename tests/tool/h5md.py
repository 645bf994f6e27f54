#!/usr/bin/python3
"""Holds a run file against the rules of H5MD 1.1 (nongnu.org/h5md). Prints what is broken."""
import sys

import h5py
import numpy as np

faults = []


def rule(holds, text):
    if not holds:
        faults.append(text)


def is_fixed_text(attribute_type):
    info = h5py.check_string_dtype(attribute_type)
    return info is not None and info.length is not None


def check_texts(name, item):
    for key in item.attrs:
        kind = item.attrs.get_id(key).dtype
        if h5py.check_string_dtype(kind):
            rule(is_fixed_text(kind), f"{name}@{key}: not of fixed length")
    if isinstance(item, h5py.Dataset) and h5py.check_string_dtype(item.dtype):
        rule(is_fixed_text(item.dtype), f"{name}: text not of fixed length")


def check_version(group):
    rule("version" in group.attrs, f"{group.name}: no version")
    version = group.attrs["version"]
    rule(version.dtype.kind == "i" and list(version) == [1, 1], f"{group.name}: version {version}")


def check_head(file):
    rule("h5md" in file, "no group h5md")
    head = file["h5md"]
    check_version(head)
    rule(is_fixed_text(head["author"].attrs.get_id("name").dtype), "author")
    for key in ("name", "version"):
        rule(is_fixed_text(head["creator"].attrs.get_id(key).dtype), "creator")
    check_version(head["modules/units"])
    rule(head["modules/units"].attrs["system"] == b"SI", "system of units")


def check_element(element):
    name = element.name
    rule({"step", "value"} <= set(element), f"{name}: step and value")
    step, value = element["step"], element["value"]
    rule(step.dtype.kind in "iu", f"{name}: step is not an integer")
    rule(step.ndim == 1 and len(step) == len(value), f"{name}: lengths")
    rule(bool(np.all(np.diff(step[()]) > 0)), f"{name}: step does not rise")
    if "time" in element:
        rule(element["time"].shape == step.shape, f"{name}: time")
        rule(element["time"].attrs["unit"] == b"s", f"{name}: unit of time")
        rule(bool(np.all(np.diff(element["time"][()]) > 0)), f"{name}: time does not rise")


def check_particles(group):
    box = group["box"]
    rule(box.attrs["dimension"] == 3 and box.attrs["dimension"].dtype.kind == "i", "box dimension")
    boundary = box.attrs["boundary"]
    rule(boundary.shape == (3,) and set(boundary) <= {b"periodic", b"none"}, "box boundary")
    rule(is_fixed_text(box.attrs.get_id("boundary").dtype), "box boundary is no fixed text")
    rule("edges" in box and box["edges"].shape == (3,), "box edges")
    count = len(group["mass"])
    for name, unit in (("mass", b"kg"), ("radius", b"m")):
        rule(group[name].shape == (count,) and group[name].attrs["unit"] == unit, name)
    rule(group["species"].dtype.kind == "i", "species")
    sampled = [n for n in ("position", "velocity", "angular_velocity") if n in group]
    for name in sampled:
        check_element(group[name])
        rule(group[name]["value"].shape[1:] == (count, 3), f"{name}: shape")
        rule("unit" in group[name]["value"].attrs, f"{name}: unit")
        # Sampled together: one and the same dataset, by hard links.
        rule(group[name]["step"] == group["position/step"], f"{name}: own step")
        rule(group[name]["time"] == group["position/time"], f"{name}: own time")


def main(path):
    with h5py.File(path, "r") as file:
        check_head(file)
        rule(set(file) <= {"h5md", "particles", "observables", "parameters", "eventmill"}, "roots")
        file.visititems(check_texts)
        for name in file["particles"]:
            check_particles(file["particles"][name])
        first = None
        for element in file.get("observables", {}).values():
            check_element(element)
            first = first or element
            rule(element["step"] == first["step"], f"{element.name}: own step")
        rule(file["parameters/scene"] == file["eventmill/scene"], "the scene is no parameter")
    for fault in faults:
        print(fault)
    return 1 if faults else 0


sys.exit(main(sys.argv[1]))
