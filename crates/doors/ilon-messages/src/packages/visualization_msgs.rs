//! Shapes for a viewer's scene.

use crate::builtin_interfaces::Duration;
use crate::declare::messages;
use crate::geometry_msgs::{Point, Pose, Vector3};
use crate::sensor_msgs::CompressedImage;
use crate::std_msgs::{ColorRGBA, Header};

messages! { visualization_msgs;
    /// A texture coordinate, each part from 0 to 1.
    #[derive(Copy)]
    UVCoordinate "f27f7ed21fe360c6066944f856b801a0c0d1e94e815b6886444b42d90b196a26" {
        /// Across.
        u: f32,
        /// Along.
        v: f32,
    }

    /// A mesh inside its message.
    #[derive(Eq)]
    MeshFile "7710ece15a148fb7c9b546364cfb215bb06098087bd6394fe5b73a493508f8c4" {
        /// Its name; the extension is the format.
        filename: String,
        /// The file.
        data: Vec<u8>,
    }

    /// A shape, or many of one kind.
    Marker "45b13ccf791f225962bf74e746f9644518855d783a6f42ba0cc14fde2b4f3ce0" const {
        /// An arrow from one point to another, or along x of the pose.
        ARROW: i32 = 0,
        /// A box.
        CUBE: i32 = 1,
        /// An ellipsoid.
        SPHERE: i32 = 2,
        /// A cylinder along z.
        CYLINDER: i32 = 3,
        /// A line through the points.
        LINE_STRIP: i32 = 4,
        /// A line between each pair of points.
        LINE_LIST: i32 = 5,
        /// A box at each point.
        CUBE_LIST: i32 = 6,
        /// An ellipsoid at each point.
        SPHERE_LIST: i32 = 7,
        /// A dot at each point.
        POINTS: i32 = 8,
        /// A text that faces the camera.
        TEXT_VIEW_FACING: i32 = 9,
        /// A mesh.
        MESH_RESOURCE: i32 = 10,
        /// A triangle between each three points.
        TRIANGLE_LIST: i32 = 11,
        /// Arrows from point to point. Viewers of older distributions do not know it.
        ARROW_STRIP: i32 = 12,
        /// Draws it, replacing the one with its namespace and number.
        ADD: i32 = 0,
        /// The same as `ADD`.
        MODIFY: i32 = 0,
        /// Removes the one with its namespace and number.
        DELETE: i32 = 2,
        /// Removes all.
        DELETEALL: i32 = 3,
    } {
        /// Time and frame.
        header: Header,
        /// The namespace, within which numbers are unique.
        ns: String,
        /// The number.
        id: i32,
        /// Shape: one of the constants from `ARROW` on.
        r#type: i32,
        /// Action: one of the constants from `ADD` on.
        action: i32,
        /// Its pose.
        pose: Pose,
        /// Its size along x, y, z, m. Lines take their width from x, texts their height from z.
        scale: Vector3,
        /// Its colour, unless `colors` has one for each point.
        color: ColorRGBA,
        /// Lifetime; unlimited if zero.
        lifetime: Duration,
        /// Whether it keeps moving with its frame.
        frame_locked: bool,
        /// Points of lines, lists and arrows, in the frame of the pose, m.
        points: Vec<Point>,
        /// The colours of the points, or none.
        colors: Vec<ColorRGBA>,
        /// URI of the texture of a mesh or of triangles.
        texture_resource: String,
        /// The texture, if included.
        texture: CompressedImage,
        /// Texture coordinates of each point.
        uv_coordinates: Vec<UVCoordinate>,
        /// The text.
        text: String,
        /// URI of the mesh.
        mesh_resource: String,
        /// The mesh, if included.
        mesh_file: MeshFile,
        /// Whether the mesh has its own colours.
        mesh_use_embedded_materials: bool,
    }

    /// Several shapes.
    MarkerArray "86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf" {
        /// The shapes.
        markers: Vec<Marker>,
    }
}
