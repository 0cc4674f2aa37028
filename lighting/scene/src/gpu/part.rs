//! The texts, with what they define.

/// Optical depths of density grids, of balls and of fog that thins out with altitude, along
/// lines `origin + t direction`, `direction` being a unit vector. Needs no other part.
///
/// Lengths are in metres; `scn_FAR`, which is `f32::MAX`, stands for infinity. `grid` is a
/// [`GridRecord`](super::GridRecord). The errors are those of the
/// [module](crate::gpu#agreement-with-the-cpu).
///
/// ```wgsl
/// fn scn_grid_depth(
///     grid: scn_Grid,
///     origin: vec3<f32>,
///     direction: vec3<f32>,
///     near: f32,
///     far: f32,
/// ) -> f32
/// ```
///
/// The optical depth of a grid for t from `near` ≥ 0 to `far`, which may be `scn_FAR`,
/// where its tint is 1: multiply with `grid.tint` for the channels.
///
/// ```wgsl
/// fn scn_walk(
///     grid: scn_Grid,
///     origin: vec3<f32>,
///     direction: vec3<f32>,
///     near: f32,
///     far: f32,
/// ) -> scn_Walk
/// fn scn_next_cell(walk: ptr<function, scn_Walk>) -> bool
/// fn scn_cubic(grid: scn_Grid, walk: scn_Walk, near: f32, far: f32) -> vec4<f32>
/// fn scn_mean(cubic: vec4<f32>) -> f32
/// fn scn_up_to(cubic: vec4<f32>, u: f32) -> vec4<f32>
/// ```
///
/// The cells of a grid on a line, from near to far. In each, the extinction in 1/m along the
/// part between two distances is a cubic over u from 0 to 1, given by its Bernstein
/// coefficients, none of which is negative. `scn_mean` is its mean, `scn_up_to` the same
/// polynomial with 0 to u as its domain, whose last coefficient is the value at u.
///
/// ```wgsl
/// var walk = scn_walk(grid, origin, direction, 0.0, distance_of_the_surface);
/// while scn_next_cell(&walk) {
///     let cubic = scn_cubic(grid, walk, walk.near, walk.far);
///     // From walk.base + walk.near to walk.base + walk.far.
///     depth += (walk.far - walk.near) * scn_mean(cubic);
/// }
/// ```
///
/// ```wgsl
/// fn scn_chord(
///     centre: vec3<f32>,
///     radius: f32,
///     origin: vec3<f32>,
///     direction: vec3<f32>,
/// ) -> vec2<f32>
/// fn scn_ball_cubic(
///     sigma_t: f32,
///     radius: f32,
///     is_soft: bool,
///     chord: vec2<f32>,
///     near: f32,
///     far: f32,
/// ) -> vec4<f32>
/// ```
///
/// The chord of a ball: the distance of its middle and half its length, 0 if the line misses
/// the ball; and the extinction between two distances within it, as such a cubic, for a ball
/// of `sigma_t` at its centre that is even, or soft and falls as 1 − r²/R².
///
/// Beside these it has all of [`HEIGHT_FOG`].
///
/// # To be written by the shader around it
///
/// ```wgsl
/// fn scn_density(index: u32) -> f32
/// ```
///
/// Entry `index` of the densities of all grids, one grid behind the other.
///
/// # Source
///
#[doc = concat!("```wgsl\n", include_str!("media.wgsl"), "\n```")]
pub const MEDIA: &str = text(concat!(
    include_str!("height_fog.wgsl"),
    include_str!("media.wgsl")
));

/// Fog that thins out with altitude alone, for shaders without grids; [`MEDIA`] contains it.
/// Needs no other part.
///
/// `fog` is a [`HeightFogRecord`](super::HeightFogRecord), `scn_FAR` stands for infinity.
///
/// ```wgsl
/// fn scn_height_density(fog: scn_HeightFog, y: f32) -> f32
/// fn scn_height_column(fog: scn_HeightFog, y: f32, slope: f32, length: f32) -> f32
/// ```
///
/// The factor on the coefficients of the fog at the height y; and the column of the way
/// over `length`, which may be `scn_FAR`, that begins at the height y and rises by `slope`
/// per metre: the length in m at the fog's own altitude that has as much of it. The optical
/// depth is `fog.sigma_t` times that.
///
/// # Source
///
#[doc = concat!("```wgsl\n", include_str!("height_fog.wgsl"), "\n```")]
pub const HEIGHT_FOG: &str = text(include_str!("height_fog.wgsl"));

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
    fn the_page_says_what_the_part_defines() {
        let data = "fn scn_density(index: u32) -> f32 { return f32(index); }";
        let named = Shader::documented(&[MEDIA, data], include_str!("part.rs")).unwrap();
        for name in ["scn_density", "scn_grid_depth", "scn_height_column"] {
            assert!(named.iter().any(|other| other == name), "{name}");
        }
    }

    #[test]
    fn the_whole_shader_is_valid() {
        Shader::new(&[MEDIA, include_str!("example.wgsl")]).unwrap();
    }

    #[test]
    fn height_fog_is_valid_alone() {
        Shader::new(&[HEIGHT_FOG]).unwrap();
    }
}
