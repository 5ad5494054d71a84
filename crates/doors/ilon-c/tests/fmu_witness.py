"""Judges an FMU by FMPy: its rules, its XML schema, and a simulation of its own.

fmu_witness.py FMU COMMANDS: COMMANDS holds a line of wheel rates for each control period. Prints
the results as JSON, floats in hexadecimal.
"""
import json
import sys

import fmpy
import numpy as np
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

fmu, commands = sys.argv[1], np.loadtxt(sys.argv[2], ndmin=2)
problems = validate_fmu(fmu)
description = fmpy.read_model_description(fmu)
references = {v.name: v.valueReference for v in description.modelVariables}
period = float(description.defaultExperiment.stepSize)
folder = fmpy.extract(fmu)
messages = []


def instance():
    slave = FMU3Slave(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="witness",
        fmiCallLogger=None,
    )
    slave.instantiate(logMessage=None)
    return slave


def begin(slave):
    slave.enterInitializationMode(startTime=0.0)
    slave.exitInitializationMode()


rates = [references[f"wheel[{k + 1}].rate_command"] for k in range(commands.shape[1])]
pose = [references[n] for n in ("position.x", "position.y", "orientation.heading")]
velocity = [references[n] for n in ("velocity.x", "velocity.y", "angular.z")]
forces = [references[n] for n in ("force.x", "force.y")]


def drive(slave, first, last):
    rows = []
    for k in range(first, last):
        slave.setFloat64(rates, commands[k].tolist())
        slave.doStep(currentCommunicationPoint=k * period, communicationStepSize=period)
        rows.append([float(x).hex() for x in slave.getFloat64(pose + velocity)])
    return rows


slave = instance()
begin(slave)
half = len(commands) // 2
first = drive(slave, 0, half)
state = slave.getFMUState()
second = drive(slave, half, len(commands))
slave.setFMUState(state)
again = drive(slave, half, len(commands))
slave.freeFMUState(state)
slave.terminate()
slave.freeInstance()

# Coupled with a plant in numpy: a mass on a spring whose other end the robot drags.
slave = instance()
begin(slave)
place, speed, stiffness, mass = 0.0, 0.0, 40.0, 2.0
slave.setFloat64(rates, commands[-1].tolist())
pulled = []
for k in range(100):
    x, y = slave.getFloat64(pose[:2])
    force = stiffness * (y - place)
    slave.setFloat64(forces, [0.0, -force])
    slave.doStep(currentCommunicationPoint=k * period, communicationStepSize=period)
    speed += force / mass * period
    place += speed * period
    pulled.append(force)
coupled = {"robot_y": slave.getFloat64(pose)[1], "mass_y": place, "most_force": max(pulled)}
slave.terminate()
slave.freeInstance()

# And by FMPy's own loop, with a parameter.
result = fmpy.simulate_fmu(
    fmu,
    stop_time=0.2,
    output_interval=period,
    start_values={"scenario.world.floor.friction": 0.3, "wheel[1].rate_command": 4.0},
    output=["position.x", "floor.friction", "wheel[1].rate"],
)
simulated = {name: float(result[name][-1]) for name in result.dtype.names}
print(json.dumps({
    "problems": problems, "rows": first + second, "again": again, "from": half, "coupled": coupled, "simulated": simulated,
}))
