"""ilon's robot under a scene of MuJoCo: needs the package `mujoco`.

ilon moves the base, MuJoCo everything else: an arm on it, a box that it pushes. What the scene puts on the base is, to first order, the
wrench W = W_0 - A a: A is the articulated-body inertia of the scene at the base (Featherstone, Rigid Body Dynamics Algorithms 2008, section
7.1), with the contacts of MuJoCo that hold now, and a the base's acceleration. ilon solves its step with A among its own masses, MuJoCo
repeats its step with the base moved as ilon moved it, and both go on from there until they agree. So nothing is late by a step, and an arm may
weigh many times what the base weighs.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import mujoco as mj
import numpy as np
import numpy.typing as npt

from ._ilon import Outcome, Simulation

__all__ = ["Base", "CouplingError"]

_Floats = npt.NDArray[np.float64]

_HEAVY = 1e3
"""How many times the scene's mass MuJoCo's base is made to weigh while it is moved as ilon says. With more, MuJoCo's solver takes what is left of
its work for done."""
_MOST_APART = 0.05
"""Share of the wrench up to which what is left over waits for the next step."""
_NEWTON = 4
"""Passes that take the tangent where they are."""
_GIVEN = mj.mjtState.mjSTATE_INTEGRATION
"""What a step of MuJoCo begins from."""
_INTEGRATORS = {
    mj.mjtIntegrator.mjINT_EULER,
    mj.mjtIntegrator.mjINT_IMPLICIT,
    mj.mjtIntegrator.mjINT_IMPLICITFAST,
}


class CouplingError(RuntimeError):
    """Both engines found no wrench between scene and base that fits both."""


class Base:
    """A body of a MuJoCo model that is moved by a simulation of ilon's.

    `body` names a child of the world with a free joint. Its frame is the robot's body frame: x forward, y left, z up, as high above MuJoCo's
    z = 0 as the robot's above its floor. Mass and inertia of that one body are ilon's, and those of the model are taken out of it; what is
    attached to it, by joints or welded, is MuJoCo's. Wheels do not belong into the model, but for their looks (`contype="0"`, without joints).

    Of both steps one is a whole number of the other; `dt_s` is the longer one. `tolerance` is the share of the wrench up to which both
    engines are brought to agree, in at most `most_passes` passes; what is left then acts in the next step, and more than a twentieth of the wrench is
    refused.
    """

    def __init__(
        self,
        model: mj.MjModel,
        data: mj.MjData,
        simulation: Simulation,
        *,
        body: str,
        tolerance: float = 1e-6,
        most_passes: int = 30,
    ) -> None:
        self.model, self.data, self.simulation = model, data, simulation
        self.tolerance, self.most_passes = tolerance, most_passes
        self.passes = 0
        """How many times the last step was solved."""
        self.disagreement_n = 0.0
        """How far both engines were apart at the end of the last step, in N and N m."""
        self.work_on_scene_j = 0.0
        """What the base has done to the scene since the start, in J, by MuJoCo's account; by ilon's it is what `outside_j` of
        `simulation.energies()` is less."""
        index = mj.mj_name2id(model, mj.mjtObj.mjOBJ_BODY, body)
        if index < 0:
            names = [mj.mj_id2name(model, mj.mjtObj.mjOBJ_BODY, other) for other in range(1, model.nbody)]
            raise ValueError(f"the model has no body {body!r}: name one of {', '.join(filter(None, names))}")
        joint = model.body_jntadr[index]
        if joint < 0 or model.jnt_type[joint] != mj.mjtJoint.mjJNT_FREE:
            raise ValueError(f"the body {body!r} has no free joint: put <freejoint/> into it, as a child of <worldbody>")
        if model.opt.integrator not in _INTEGRATORS:
            raise ValueError("a base is moved with the integrators Euler, implicit and implicitfast: set <option integrator>")
        for wheel in simulation.wheel_names:
            if mj.mj_name2id(model, mj.mjtObj.mjOBJ_JOINT, wheel) >= 0:
                raise ValueError(f"the model has a joint {wheel!r}, which is a wheel of ilon's: take its body out of the model")
        self._at = int(model.jnt_qposadr[joint])
        first = int(model.jnt_dofadr[joint])
        self._dofs = np.arange(first, first + 6)
        self._others = np.setdiff1d(np.arange(model.nv), self._dofs)
        self._model_steps, self._plant_steps = _steps(float(model.opt.timestep), simulation.physics_dt_s)
        self.dt_s = self._model_steps * float(model.opt.timestep)
        """The time that a step takes, in s."""
        down = simulation.body().gravity_in_world_m_s2
        if not np.isclose(np.linalg.norm(down), np.linalg.norm(model.opt.gravity), rtol=1e-3):
            raise ValueError(
                f"gravity is {np.linalg.norm(model.opt.gravity):.6g} m/s^2 in the model and {np.linalg.norm(down):.6g} in ilon's: "
                "make both alike, by <option gravity> or world.gravity_m_s2"
            )
        # Its own inertia is in ilon.
        model.body_subtreemass[[0, index]] -= model.body_mass[index]
        model.body_mass[index] = 0.0
        model.body_inertia[index] = 0.0
        # Of a body to which nothing is attached, MuJoCo takes the masses from here.
        model.dof_M0[self._dofs] = model.dof_armature[self._dofs]
        scene_kg = max(float(model.body_subtreemass[0]), 1.0)
        self._armature = _HEAVY * scene_kg * np.ones(6)
        self._acceleration = np.zeros(6)
        self._wrench = np.zeros(6)
        self._owed = np.zeros(6)
        self.align()

    def align(self) -> None:
        """Puts MuJoCo's body where ilon's is, as fast: after a reset of either, or when ilon's was moved."""
        body, at = self.simulation.body(), self._at
        self.data.qpos[at : at + 3] = body.position_m
        self.data.qpos[at + 3 : at + 7] = body.quaternion_wxyz
        self.data.qvel[self._dofs] = _rates(body)
        self.model.opt.gravity[:] = body.gravity_in_world_m_s2
        with self._heavy():
            mj.mj_forward(self.model, self.data)

    @contextmanager
    def _heavy(self) -> Iterator[None]:
        """Adds mass to the base: MuJoCo cannot move one without."""
        added = (self.model.dof_armature, self.model.dof_M0)
        before = [of[self._dofs].copy() for of in added]
        for of in added:
            of[self._dofs] = self._armature
        try:
            yield
        finally:
            for of, values in zip(added, before, strict=True):
                of[self._dofs] = values

    def step(self, wheel_rates: npt.ArrayLike | None = None, *, torques: npt.ArrayLike | None = None) -> Outcome:
        """Lets both go on by `dt_s`: the robot by wheel rates in rad/s or torques in N m, the scene by what is in `data`. Raises
        `CouplingError` where no wrench fits both: take shorter steps then, or softer contacts in MuJoCo."""
        model, data, plant = self.model, self.data, self.simulation
        begin = np.empty(mj.mj_stateSize(model, _GIVEN))
        mj.mj_getState(model, data, begin, _GIVEN)
        before, body = plant.snapshot(), plant.body()
        turned = np.eye(6)
        turned[3:, 3:] = _matrix(body.quaternion_wxyz)
        rates = _rates(body)
        given = self._acceleration
        wrench, inertia = self._scene(given)
        for self.passes in range(1, self.most_passes + 1):
            # The scene's wrench on an unaccelerated base, by the tangent at the last trial.
            at_rest = turned @ (wrench + inertia @ given + self._owed)
            plant.set_articulated_inertia(turned @ inertia @ turned.T)
            plant.set_wrench(at_rest[:3], at_rest[3:], place_m=[0.0, 0.0, 0.0])
            outcome = plant.advance(wheel_rates, torques=torques, period_s=self.dt_s)
            moved = (_rates(plant.body()) - rates) / self.dt_s
            acted = wrench + inertia @ (given - moved) + self._owed
            mj.mj_setState(model, data, begin, _GIVEN)
            given = moved
            # If dry friction reverses within the iteration, the tangents of both sides can
            # alternate forever. The mean of the loosest and the stiffest tangent is at least half
            # of either, and converges.
            self._wrench = wrench
            held = "as it is" if self.passes < _NEWTON else "all"
            if self.passes <= _NEWTON:
                loose = inertia
                wrench, inertia = self._scene(given, held)
                inertia = inertia if self.passes < _NEWTON else (inertia + loose) / 2
            else:
                wrench, _ = self._scene(given, held)
            apart = wrench + self._owed - acted
            self.disagreement_n = float(np.abs(apart).max())
            share = self.disagreement_n / max(1.0, float(np.abs(wrench).max()))
            if share <= self.tolerance:
                break
            if self.passes < self.most_passes:
                plant.restore(before)
        if share > _MOST_APART:
            raise CouplingError(
                f"base and scene disagree by {self.disagreement_n:.3g} N at {plant.time_s:.4f} s after {self.passes} passes: "
                "take shorter steps, or make MuJoCo's contacts and joints softer (solref, frictionloss)"
            )
        # The remainder of this step is applied in the next.
        self._owed = apart
        self._acceleration, self._wrench = given, wrench
        after = plant.body()
        self.work_on_scene_j -= float(wrench @ (rates + _rates(after))) / 2 * self.dt_s
        at = self._at
        data.qpos[at : at + 3] = after.position_m
        data.qpos[at + 3 : at + 7] = after.quaternion_wxyz
        data.qvel[self._dofs] = _rates(after)
        model.opt.gravity[:] = after.gravity_in_world_m_s2
        return outcome

    def scene_energy_j(self) -> tuple[float, float]:
        """Kinetic and potential energy of the scene now, without the base's own body, in J."""
        model, data = self.model, self.data
        # Everything that energies need, without a division by the mass of the base.
        for part in (mj.mj_kinematics, mj.mj_comPos, mj.mj_tendon, mj.mj_makeM, mj.mj_energyPos):
            part(model, data)
        product = np.zeros(model.nv)
        mj.mj_mulM(model, data, product, data.qvel)
        return float(data.qvel @ product) / 2, float(data.energy[0])

    def _scene(self, acceleration: _Floats, held: str = "as it is") -> tuple[_Floats, _Floats]:
        """Advances the scene with a base of this acceleration. Returns the mean wrench on the base,
        and its decrease per acceleration at the start of the step; both along the axes of MuJoCo's
        free joint: the force's along the world's, the moment's along the body's.
        """
        model, data, dofs = self.model, self.data, self._dofs
        wrench, inertia = np.zeros(6), np.zeros((6, 6))
        applied = data.qfrc_applied[dofs].copy()
        pushes = self._armature * acceleration - self._wrench
        data.qfrc_applied[dofs] = applied + pushes
        try:
            with self._heavy():
                for step in range(self._model_steps):
                    rates = data.qvel.copy()
                    mj.mj_step(model, data)
                    gained = (data.qvel - rates) / model.opt.timestep
                    masses = self._masses()
                    acted = data.qfrc_smooth[dofs] + data.qfrc_constraint[dofs] - pushes
                    wrench += (acted - masses[dofs] @ gained) / self._model_steps
                    if step == 0:
                        inertia = self._tangent(masses, held)
        finally:
            data.qfrc_applied[dofs] = applied
        return wrench, inertia

    def _masses(self) -> _Floats:
        """The scene's mass matrix at the beginning of MuJoCo's last step, without the mass added to
        the base.
        """
        model, data = self.model, self.data
        masses = np.zeros((model.nv, model.nv))
        mj.mj_fullM(model, data, masses)
        masses[self._dofs, self._dofs] -= self._armature
        return masses

    def _tangent(self, masses: _Floats, held: str) -> _Floats:
        """The articulated inertia of the scene at the base: the Schur complement of its masses,
        dampers and constraints, either active or all.
        """
        model, data = self.model, self.data
        whole = masses + np.diag(model.opt.timestep * np.asarray(model.dof_damping).reshape(model.nv, -1)[:, 0])
        if data.nefc:
            rows = np.zeros((data.nefc, model.nv))
            if mj.mj_isSparse(model):
                mj.mju_sparse2dense(rows, data.efc_J, data.efc_J_rownnz, data.efc_J_rowadr, data.efc_J_colind)
            else:
                rows[:] = data.efc_J.reshape(data.nefc, model.nv)
            quadratic = mj.mjtConstraintState.mjCNSTRSTATE_QUADRATIC
            holds = (data.efc_state == quadratic) | (held == "all")
            rows = rows[holds]
            whole = whole + rows.T @ (data.efc_D[holds, None] * rows)
        base, others = self._dofs, self._others
        between = whole[np.ix_(others, base)]
        tangent = whole[np.ix_(base, base)]
        if len(others):
            tangent = tangent - between.T @ np.linalg.solve(whole[np.ix_(others, others)], between)
        return (tangent + tangent.T) / 2


def _rates(body: Any) -> _Floats:
    """A body's velocity in the convention of MuJoCo's free joint: linear along the world's axes,
    angular along the body's.
    """
    return np.concatenate([body.velocity_in_world_m_s, body.angular_in_body_rad_s])


def _matrix(quaternion: _Floats) -> _Floats:
    matrix = np.zeros(9)
    mj.mju_quat2Mat(matrix, quaternion)
    return matrix.reshape(3, 3)


def _steps(of_model_s: float, of_plant_s: float) -> tuple[int, int]:
    """The number of steps of each engine in the longer of both steps."""
    longer = max(of_model_s, of_plant_s)
    counts = round(longer / of_model_s), round(longer / of_plant_s)
    for count, step_s in zip(counts, (of_model_s, of_plant_s), strict=True):
        if abs(count * step_s - longer) > 1e-9 * longer:
            raise ValueError(
                f"steps of {of_model_s} s in MuJoCo and {of_plant_s} s in ilon do not fit: make one a whole number of the other, by "
                "<option timestep> or run.physics_dt_s"
            )
    return counts
