//! The texts, with what they define.

/// Questions about single voxels and texels. Needs [`PLAIN`] or [`PACKED`], in any order.
///
/// `dag` is a [`DagRecord`](super::DagRecord), usually in a uniform.
///
/// ```wgsl
/// fn dag_is_lit(dag: dag_Shadows, voxel: vec3<i32>) -> bool
/// fn dag_depth(dag: dag_Shadows, texel: vec2<u32>) -> u32
/// fn dag_side(dag: dag_Shadows) -> u32
/// ```
///
/// Whether a voxel is lit: beside the map and in front of the first slice all are, behind
/// the last slice it is as in the last. The first slice of a texel that is shadowed, or the
/// number of slices. The voxels along each axis. All bit by bit as on the CPU.
///
/// # To be written by the shader around it
///
/// ```wgsl
/// fn dag_word(index: u32) -> u32
/// ```
///
/// A word of [`ResidentDag::words`](crate::ShadowDag::words).
///
/// # Source
///
#[doc = concat!("```wgsl\n", include_str!("point.wgsl"), "\n```")]
pub const POINT: &str = text(include_str!("point.wgsl"));

/// Nodes of [`Form::Plain`](crate::Form::Plain), for [`POINT`]: `dag_node` and `dag_child`,
/// which are not for others.
///
/// # Source
///
#[doc = concat!("```wgsl\n", include_str!("plain.wgsl"), "\n```")]
pub const PLAIN: &str = text(include_str!("plain.wgsl"));

/// Nodes of [`Form::Packed`](crate::Form::Packed), for [`POINT`]: `dag_node` and `dag_child`,
/// which are not for others.
///
/// # Source
///
#[doc = concat!("```wgsl\n", include_str!("packed.wgsl"), "\n```")]
pub const PACKED: &str = text(include_str!("packed.wgsl"));

/// Filters and boxes. Needs [`POINT`].
///
/// ```wgsl
/// fn dag_filter(dag: dag_Shadows, voxel: vec3<i32>, width: u32) -> f32
/// fn dag_count_lit(dag: dag_Shadows, voxel: vec3<i32>, width: u32) -> u32
/// ```
///
/// The lit share, from 0 to 1, of the `width × width` voxels around a voxel in its slice, and
/// their number. `width` is odd and at most 65535: those are the widths of a
/// [`FilterSize`](crate::FilterSize). The number is that of the CPU, the share within 3 units
/// in the last place. For a surface, `dag_bias` of [`SPACE`] gives the voxel:
///
/// ```wgsl
/// let h = dag_homogeneous(space, vec4(point, 1.0));
/// let voxel = dag_bias(dag_position(space, h), dag_normal(space, h, normal), 9u);
/// let light = dag_filter(dag, voxel, 9u);
/// ```
///
/// ```wgsl
/// fn dag_filter_bilinear(dag: dag_Shadows, position: vec3<f32>, width: u32) -> f32
/// ```
///
/// The share of a window that lies around a position exactly and so changes smoothly along
/// the map; positions that are not finite are lit. Four filters, but one walk.
///
/// ```wgsl
/// fn dag_visibility(dag: dag_Shadows, first: vec3<i32>, last: vec3<i32>) -> u32
/// ```
///
/// What there is in a box of voxels, ends included: bit 0 for lit ones, bit 1 for shadowed
/// ones.
///
/// # Source
///
#[doc = concat!("```wgsl\n", include_str!("extent.wgsl"), "\n```")]
pub const EXTENT: &str = text(include_str!("extent.wgsl"));

/// From the world to the grid of a light. Needs no other part.
///
/// `space` is a [`SpaceRecord`](super::SpaceRecord), usually in a uniform.
///
/// ```wgsl
/// fn dag_homogeneous(space: dag_Space, point: vec4<f32>) -> vec4<f32>
/// fn dag_position(space: dag_Space, h: vec4<f32>) -> vec3<f32>
/// fn dag_voxel_at(position: vec3<f32>) -> vec3<i32>
/// ```
///
/// Homogeneous coordinates of a point of the world in metres (w = 1) or of a direction (w =
/// 0); the position in the grid that they mean, in voxels, for points in front of the
/// light, which is `h.w > 0`; and the voxel of a position. Points are off by what the
/// [module](crate::gpu#agreement-with-the-cpu) says.
///
/// ```wgsl
/// fn dag_normal(space: dag_Space, h: vec4<f32>, normal: vec3<f32>) -> vec3<f32>
/// fn dag_bias(position: vec3<f32>, normal: vec3<f32>, width: u32) -> vec3<i32>
/// ```
///
/// The direction in the grid of a surface normal of the world, a unit vector, or 0 where
/// there is none; and the voxel at which to ask a filter of `width` for the light on that
/// surface: half a width along the normal, so that the window clears the surface.
///
/// # Source
///
#[doc = concat!("```wgsl\n", include_str!("space.wgsl"), "\n```")]
pub const SPACE: &str = text(include_str!("space.wgsl"));

/// Lit parts of rays. Needs [`POINT`] and [`SPACE`].
///
/// ```wgsl
/// struct dag_LitInterval {
///     start: f32,
///     end: f32,
/// }
/// fn dag_cursor(
///     space: dag_Space,
///     origin: vec3<f32>,
///     direction: vec3<f32>,
///     start: f32,
///     end: f32,
/// ) -> dag_Cursor
/// fn dag_next_lit(dag: dag_Shadows, space: dag_Space, cursor: ptr<function, dag_Cursor>) -> dag_LitInterval
/// ```
///
/// A cursor looks at the points `origin + s · direction` with `s` from `start` ≥ 0 to `end`,
/// which may be `dag_FAR`; for a direction of length 1 both are metres. It hands out the lit
/// parts from near to far; an interval without length says that there are no more.
///
/// ```wgsl
/// var cursor = dag_cursor(space, eye, direction, 0.0, distance_of_the_surface);
/// loop {
///     let lit = dag_next_lit(dag, space, &cursor);
///     if lit.start == lit.end { break; }
///     sum += light_between(lit.start, lit.end);
/// }
/// ```
///
/// A step for each homogeneous volume on the way.
///
/// ```wgsl
/// fn dag_lit_length(dag: dag_Shadows, space: dag_Space, cursor: ptr<function, dag_Cursor>) -> f32
/// ```
///
/// The length of all lit parts together, for a cursor at its beginning.
///
/// # Source
///
#[doc = concat!("```wgsl\n", include_str!("ray.wgsl"), "\n```")]
pub const RAY: &str = text(include_str!("ray.wgsl"));

/// The text itself. A call keeps it out of the line in which the documentation shows the
/// constant.
const fn text(source: &'static str) -> &'static str {
    source
}

#[cfg(test)]
mod tests {
    use gpu_backend::testing::Shader;

    use super::*;

    #[test]
    fn pages_say_what_the_parts_define() {
        let data = "fn dag_word(index: u32) -> u32 { return index; }";
        for form in [PLAIN, PACKED] {
            let parts = [POINT, form, EXTENT, SPACE, RAY, data];
            let named = Shader::documented(&parts, include_str!("parts.rs")).unwrap();
            for name in ["dag_word", "dag_filter", "dag_next_lit"] {
                assert!(named.iter().any(|other| other == name), "{name}");
            }
        }
    }
}
