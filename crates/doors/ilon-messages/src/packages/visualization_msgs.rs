//! Shapes to be drawn into a viewer's scene.

use crate::builtin_interfaces::Duration;
use crate::declare::messages;
use crate::geometry_msgs::{Point, Pose, Vector3};
use crate::sensor_msgs::CompressedImage;
use crate::std_msgs::{ColorRGBA, Header};

messages! { visualization_msgs;
    /// A place in a texture, each coordinate from 0 to 1.
    #[derive(Copy)]
    UVCoordinate "f27f7ed21fe360c6066944f856b801a0c0d1e94e815b6886444b42d90b196a26" {
        /// Across.
        u: f32,
        /// Along.
        v: f32,
    }

    /// A mesh that comes with its message.
    #[derive(Eq)]
    MeshFile "7710ece15a148fb7c9b546364cfb215bb06098087bd6394fe5b73a493508f8c4" {
        /// Its name, of which the ending is the format.
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
        /// A line between each two points.
        LINE_LIST: i32 = 5,
        /// A box at each point.
        CUBE_LIST: i32 = 6,
        /// An ellipsoid at each point.
        SPHERE_LIST: i32 = 7,
        /// A dot at each point.
        POINTS: i32 = 8,
        /// A text that faces who looks at it.
        TEXT_VIEW_FACING: i32 = 9,
        /// A mesh.
        MESH_RESOURCE: i32 = 10,
        /// A triangle between each three points.
        TRIANGLE_LIST: i32 = 11,
        /// Arrows from point to point. Viewers of older distributions do not know it.
        ARROW_STRIP: i32 = 12,
        /// Draw it, in place of the one with its namespace and number.
        ADD: i32 = 0,
        /// The same as `ADD`.
        MODIFY: i32 = 0,
        /// Take away the one with its namespace and number.
        DELETE: i32 = 2,
        /// Take away all.
        DELETEALL: i32 = 3,
    } {
        /// When, and in which frame.
        header: Header,
        /// The namespace, within which numbers are unique.
        ns: String,
        /// The number.
        id: i32,
        /// Which shape: one of the constants from `ARROW` on.
        r#type: i32,
        /// What to do: one of the constants from `ADD` on.
        action: i32,
        /// Where it is.
        pose: Pose,
        /// Its size along x, y, z, m. Lines take their width from x, texts their height from z.
        scale: Vector3,
        /// Its colour, unless `colors` has one for each point.
        color: ColorRGBA,
        /// How long it stays; forever if zero.
        lifetime: Duration,
        /// Whether it moves on with its frame.
        frame_locked: bool,
        /// Points of lines, lists and arrows, in the frame of the pose, m.
        points: Vec<Point>,
        /// The colours of the points, or none.
        colors: Vec<ColorRGBA>,
        /// Where the texture of a mesh or of triangles is to be had.
        texture_resource: String,
        /// The texture, if it comes along.
        texture: CompressedImage,
        /// Where in the texture each point lies.
        uv_coordinates: Vec<UVCoordinate>,
        /// The text.
        text: String,
        /// Where the mesh is to be had.
        mesh_resource: String,
        /// The mesh, if it comes along.
        mesh_file: MeshFile,
        /// Whether the mesh has colours of its own.
        mesh_use_embedded_materials: bool,
    }

    /// Several shapes.
    MarkerArray "86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf" {
        /// The shapes.
        markers: Vec<Marker>,
    }
}
