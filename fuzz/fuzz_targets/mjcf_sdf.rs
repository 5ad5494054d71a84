//! A damaged MJCF or SDF file loads or is refused with a message; one that loads can be inspected
//! and placed in a world.
#![no_main]

use ilon_files::FileAccess;
use ilon_formats::LoadRobot;
use ilon_robot::Robot;
use libfuzzer_sys::{fuzz_mutator, fuzz_target};

/// What the file may include: a part in each format, and a mesh.
const PARTS: [(&str, &str); 3] = [
    (
        "part.xml",
        "<mujoco><worldbody><body name=\"part\"><geom type=\"box\" size=\"0.1 0.1 0.1\" mass=\"1\"/></body></worldbody></mujoco>",
    ),
    (
        "part/model.sdf",
        "<sdf version=\"1.9\"><model name=\"part\"><link name=\"part\"><inertial><mass>1</mass></inertial></link></model></sdf>",
    ),
    (
        "mesh.obj",
        "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n",
    ),
];

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    ilon_fuzz::mutate(data, size, max_size, seed, b'<')
});

fuzz_target!(|text: &str| {
    let is_mjcf = text.contains("<mujoco");
    let name = if is_mjcf { "robot.xml" } else { "robot.sdf" };
    let parts = PARTS.map(|(name, text)| (name.into(), text.as_bytes().to_vec()));
    let all = parts
        .into_iter()
        .chain([(name.into(), text.as_bytes().to_vec())]);
    let files = FileAccess::of_memory(all);
    let mut options = ilon_fuzz::pick(ilon_fuzz::ways(), text.as_bytes());
    options.files = files;
    match Robot::load_with(name, &options) {
        Ok(loaded) => {
            let _ = loaded.visual_meshes();
            ilon_fuzz::use_robot(&loaded.robot);
        }
        Err(error) => assert!(!error.to_string().is_empty() && !error.help().is_empty()),
    }
});
