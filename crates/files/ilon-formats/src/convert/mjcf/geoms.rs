//! Geoms: their shapes and masses.

use std::path::Path;

use mjcf_rs::assets::{Mesh, MeshInertia};
use mjcf_rs::body as mj;
use nalgebra::{Isometry3, Matrix3, Point3, UnitQuaternion, Vector3};

use super::mesh_weight;
use super::model::{Robot, pose};
use crate::convert::ellipsoid::{Placed, ellipsoid};
use crate::convert::writer::ShapeOf;
use crate::model::MassProperties;
use crate::solid::Solid;
use crate::urdf::{Meshes, mesh_triangles};

/// Density of a geom that says none, in kg/m^3: MuJoCo's own.
const DENSITY_KG_M3: f64 = 1000.0;

/// Gives a geom that is said by its ends, `fromto`, the place, the turn and the sizes that it has
/// by them, as MuJoCo does: its z axis lies along the line between them, and of a box and an
/// ellipsoid both sizes across are the first.
pub(super) fn put_between_ends(geom: &mut mj::Geom) {
    let Some([ax, ay, az, bx, by, bz]) = geom.fromto else {
        return;
    };
    let (from, to) = (Vector3::new(ax, ay, az), Vector3::new(bx, by, bz));
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let across = geom.size[0];
    geom.size = match geom.type_ {
        mj::GeomType::Capsule | mj::GeomType::Cylinder => [across, half.norm(), 0.0],
        mj::GeomType::Box | mj::GeomType::Ellipsoid => [across, across, half.norm()],
        _ => return,
    };
    // Of opposite directions any turn does.
    let turn = UnitQuaternion::rotation_between(&Vector3::z(), &half).unwrap_or_default();
    let (place, turned) = (&mut geom.pose.translation, &mut geom.pose.rotation);
    (place.x, place.y, place.z) = (middle.x, middle.y, middle.z);
    (turned.x, turned.y, turned.z, turned.w) = (turn.i, turn.j, turn.k, turn.w);
}

/// The shapes that stand for a geom, placed in its frame; in words, why it is not read.
pub(super) fn shapes_of(geom: &mj::Geom, model: &mjcf_rs::Model) -> Result<Placed, &'static str> {
    let [x, y, z] = geom.size;
    let here = |shape| Ok(vec![(Isometry3::identity(), shape)]);
    let positive = |sizes: &[f64]| sizes.iter().all(|s| s.is_finite() && *s > 0.0);
    match geom.type_ {
        mj::GeomType::Sphere if positive(&[x]) => here(ShapeOf::Sphere(x)),
        mj::GeomType::Box if positive(&[x, y, z]) => {
            here(ShapeOf::Box(Vector3::new(x, y, z) * 2.0))
        }
        mj::GeomType::Cylinder if positive(&[x, y]) => here(ShapeOf::Cylinder {
            radius: x,
            length: 2.0 * y,
        }),
        mj::GeomType::Capsule if positive(&[x, y]) => here(ShapeOf::Capsule {
            radius: x,
            length: 2.0 * y,
        }),
        mj::GeomType::Ellipsoid if positive(&[x, y, z]) => ellipsoid([x, y, z])
            .ok_or("an ellipsoid is not read that is not round across its longest axis"),
        mj::GeomType::Mesh => match mesh(geom, model) {
            Some(shape) => here(shape),
            None => Err("a mesh without a file counts for the mass, but touches nothing"),
        },
        _ => Err(
            "a geom is not read: it is neither sphere, box, cylinder, capsule, ellipsoid nor mesh, or has no size",
        ),
    }
}

fn mesh(geom: &mj::Geom, model: &mjcf_rs::Model) -> Option<ShapeOf> {
    let mesh = called(model, geom.mesh.as_deref()?)?;
    let compiler = &model.compiler;
    let folder = compiler.mesh_dir.as_ref().or(compiler.asset_dir.as_ref());
    let file = mesh.file.as_deref()?;
    let file = folder.map_or(file.into(), |folder| Path::new(folder).join(file));
    Some(ShapeOf::Mesh {
        file: file.display().to_string(),
        scale: Vector3::from(mesh.scale),
    })
}

/// The mesh of a name: its own, or that of its file.
fn called<'m>(model: &'m mjcf_rs::Model, name: &str) -> Option<&'m Mesh> {
    let is_called = |mesh: &&Mesh| {
        let stem = mesh
            .file
            .as_deref()
            .and_then(|f| Path::new(f).file_stem()?.to_str());
        mesh.name.as_deref().or(stem) == Some(name)
    };
    model.assets.meshes.iter().find(is_called)
}

/// What a body's geoms weigh together, as MuJoCo has it; `None` of those that weigh nothing.
///
/// # Errors
/// Why a mesh's weight is not known, in words.
pub(super) fn weight_of(
    geoms: &[mj::Geom],
    robot: &Robot,
    meshes: &Meshes,
) -> Result<Option<MassProperties>, String> {
    let mut parts: Vec<MassProperties> = Vec::new();
    for geom in geoms {
        let density = geom.density.unwrap_or(DENSITY_KG_M3);
        if geom.mass.unwrap_or(density) <= 0.0 {
            continue;
        }
        let own = match geom.type_ {
            mj::GeomType::Mesh => Some(of_mesh(geom, robot, meshes)?),
            _ => of_shape(geom),
        };
        parts.extend(own.map(|own| {
            let mass_kg = geom.mass.unwrap_or(density * own.mass_kg);
            own.weighing(mass_kg).moved(&pose(&geom.pose))
        }));
    }
    Ok(MassProperties::merged(&parts))
}

/// A geom's mesh for the density of 1 kg/m^3, in the geom's frame.
fn of_mesh(geom: &mj::Geom, robot: &Robot, meshes: &Meshes) -> Result<MassProperties, String> {
    let name = geom.mesh.as_deref().unwrap_or_default();
    let not_there = || format!("the mesh `{name}` has no file");
    let asset = called(robot.model, name).ok_or_else(not_there)?;
    // mjcf-rs does not tell what is said from MuJoCo's default.
    let said = robot
        .root_node
        .descendants()
        .filter(|n| n.has_tag_name("mesh"))
        .filter_map(|n| n.attribute("inertia"))
        .find(|said| *said == "convex");
    if let Some(said) = said.filter(|_| asset.inertia == MeshInertia::Convex) {
        return Err(format!("`inertia=\"{said}\"` of a mesh is not read"));
    }
    let reference = pose(&asset.refpose);
    if reference.translation.vector.norm() + reference.rotation.angle() > 0.0 {
        return Err(format!(
            "`refpos` and `refquat` of the mesh `{name}` are not read"
        ));
    }
    let scale = Vector3::from(asset.scale);
    let triangles = if let Some(ShapeOf::Mesh { file, .. }) = mesh(geom, robot.model) {
        let path = meshes.find(&file).map_err(|fault| fault.to_string())?;
        let triangles = mesh_triangles(&path, meshes.files())
            .map_err(|reason| format!("the mesh `{}` cannot be read: {reason}", path.display()))?;
        let corner = |[x, y, z]: [f32; 3]| {
            Point3::from(Vector3::new(x, y, z).cast::<f64>().component_mul(&scale))
        };
        triangles.into_iter().map(|t| t.map(corner)).collect()
    } else {
        let numbers = asset.inline_vertices.as_deref().ok_or_else(not_there)?;
        let corner = |p: &[f64; 3]| Point3::from(Vector3::from(*p).component_mul(&scale));
        let odd = |what: &str| format!("the `{what}` of mesh `{name}` is not in threes");
        let (points, []) = numbers.as_chunks() else {
            return Err(odd("vertex"));
        };
        let corners: Vec<Point3<f64>> = points.iter().map(corner).collect();
        let at = |i: &u32| corners.get(*i as usize).copied();
        let side = |[a, b, c]: &[u32; 3]| Some([at(a)?, at(b)?, at(c)?]);
        match asset.inline_faces.as_deref().map(<[u32]>::as_chunks) {
            Some((faces, [])) => {
                faces
                    .iter()
                    .map(side)
                    .collect::<Option<_>>()
                    .ok_or_else(|| {
                        format!("the `face` of mesh `{name}` names a vertex that it lacks")
                    })?
            }
            Some(_) => return Err(odd("face")),
            None => mesh_weight::hull(&corners)
                .ok_or_else(|| format!("the mesh `{name}` encloses nothing"))?,
        }
    };
    mesh_weight::solid(&triangles, asset.inertia)
        .ok_or_else(|| format!("the mesh `{name}` encloses nothing"))
}

/// A geom that is no mesh for the density of 1 kg/m^3, in its frame; `None` of one without a
/// volume.
fn of_shape(geom: &mj::Geom) -> Option<MassProperties> {
    let [x, y, z] = geom.size;
    let halves = Vector3::new(x, y, z);
    let (radius_m, length_m) = (x, 2.0 * y);
    let solid = match geom.type_ {
        mj::GeomType::Sphere => Solid::ball(x),
        mj::GeomType::Box => Solid::Box {
            size_m: 2.0 * halves,
        },
        mj::GeomType::Ellipsoid => Solid::Ellipsoid {
            half_axes_m: halves,
        },
        mj::GeomType::Cylinder => Solid::Cylinder { radius_m, length_m },
        mj::GeomType::Capsule => Solid::Capsule { radius_m, length_m },
        _ => return None,
    };
    let volume_m3 = solid.volume_m3();
    (volume_m3 > 0.0).then(|| solid.weighing(volume_m3))
}

/// The matrix of a tensor in words of MuJoCo.
pub(super) fn tensor(inertia: &mj::InertiaSpec) -> Matrix3<f64> {
    match inertia {
        mj::InertiaSpec::Diagonal(moments) => Matrix3::from_diagonal(&Vector3::from(*moments)),
        mj::InertiaSpec::Full([xx, yy, zz, xy, xz, yz]) => {
            Matrix3::new(*xx, *xy, *xz, *xy, *yy, *yz, *xz, *yz, *zz)
        }
    }
}
