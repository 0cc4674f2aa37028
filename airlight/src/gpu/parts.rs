//! The texts, with what they define.

/// Phase functions.
///
/// ```wgsl
/// fn air_phase(kind: u32, parameters: vec4<f32>, one_minus_cos: f32, one_plus_cos: f32) -> f32
/// ```
///
/// The phase function in 1/sr. `kind` and `parameters` are the fields of a
/// [`PhaseRecord`](super::PhaseRecord), or one of the constants `air_ISOTROPIC`,
/// `air_HENYEY_GREENSTEIN`, `air_RAYLEIGH`, `air_SCHLICK`, `air_CORNETTE_SHANKS`,
/// `air_DOUBLE_HENYEY_GREENSTEIN` and `air_HENYEY_GREENSTEIN_DRAINE`. The angle θ between
/// the directions before and after scattering is given by 1 − cos θ and 1 + cos θ, both
/// from 0 to 2: where one of them is small, form it without subtracting, and sharp peaks
/// keep their digits. The error is then some roundings.
///
/// ```wgsl
/// fn air_phase_from_foot(kind: u32, parameters: vec4<f32>, s: f32, h: f32) -> f32
/// ```
///
/// The same at a point of an eye ray that lies `s` metres behind the foot point of a point
/// light, for a ray that passes the light at `h` metres; not both may be 0. For a
/// directional light the angle is the same along the whole ray: call `air_phase`.
///
/// # Source
///
#[doc = concat!("```wgsl\n", include_str!("phase.wgsl"), "\n```")]
pub const PHASE: &str = text(include_str!("phase.wgsl"));

/// Parts of eye rays as a point light sees them.
///
/// ```wgsl
/// struct air_Segment {
///     x: f32,
///     s: f32,
///     h: f32,
///     length: f32,
/// }
/// ```
///
/// The shader's side of [`Segment`](crate::Segment), in metres, with the same layout.
/// `length` may be `air_FAR`, which is `f32::MAX` and stands for infinity.
///
/// ```wgsl
/// fn air_segment(eye: vec3<f32>, direction: vec3<f32>, light: vec3<f32>, distance: f32) -> air_Segment
/// ```
///
/// The first `distance` metres of the ray from `eye` along the unit vector `direction`:
/// [`Segment::from_ray`](crate::Segment::from_ray). `s` and `h` are within 2⁻²¹ of the
/// distance between eye and light, so that the airlight of rays that pass the light at a
/// thousandth of that is right to 5e-4.
///
/// ```wgsl
/// fn air_part(segment: air_Segment, start: f32, end: f32) -> air_Segment
/// ```
///
/// What lies between two distances from the start of a segment:
/// [`Segment::part`](crate::Segment::part). Shadows divide a ray into lit parts; whatever
/// finds them, the airlight of the ray is the sum over them:
///
/// ```wgsl
/// let ray = air_segment(eye, direction, light, distance_of_the_surface);
/// var airlight = 0.0;
/// for (var i = 0u; i < lit_parts; i++) {
///     airlight += air_table_airlight(sigma_t, air_part(ray, lit[i].start, lit[i].end));
/// }
/// let radiance = sigma_s * intensity * airlight;
/// ```
///
/// # Source
///
#[doc = concat!("```wgsl\n", include_str!("segment.wgsl"), "\n```")]
pub const SEGMENT: &str = text(include_str!("segment.wgsl"));

/// Powers of two, products and distances that do not overflow. Needs [`SEGMENT`].
///
/// ```wgsl
/// fn air_exp2(x: f32) -> f32
/// ```
///
/// 2ˣ within 3e-7 of itself and the error of `x`; WGSL's own may be off by 2 |x| units of
/// the last digit. `air_FAR` from x = 128 on, 0 below −126. `air_LOG2_E` is log₂ e.
///
/// ```wgsl
/// fn air_exp2_times(value: f32, x: f32, exponent: i32) -> f32
/// fn air_scale(value: f32, exponent: i32) -> f32
/// ```
///
/// `value · 2^(x + exponent)` and `value · 2^exponent` for values of at least 0, without
/// an overflow on the way.
///
/// ```wgsl
/// fn air_product(a: f32, b: f32) -> f32
/// fn air_distance(s: f32, h: f32) -> f32
/// fn air_is_finite(value: f32) -> bool
/// ```
///
/// The product of two numbers of at least 0, or 1024 where it is more; √(s² + h²) of
/// numbers that are 0 or between 2⁻¹⁰⁰ and 2⁶¹; false for infinities and NaN, which
/// comparisons may not tell.
///
/// # Source
///
#[doc = concat!("```wgsl\n", include_str!("numeric.wgsl"), "\n```")]
pub const NUMERIC: &str = text(include_str!("numeric.wgsl"));

/// A segment in a unit in which its squares are in range; what the evaluators build on.
/// Needs [`NUMERIC`].
///
/// ```wgsl
/// fn air_scaled(sigma_t: f32, segment: air_Segment) -> air_Scaled
/// ```
///
/// `kind` of the result is `air_ORDINARY`, `air_MEETS_LIGHT` for a segment that contains
/// the light, or `air_EMPTY` where there is no airlight: no length, no light left, numbers
/// that are no lengths. `sigma_t` is the extinction in 1/m.
///
/// # Source
///
#[doc = concat!("```wgsl\n", include_str!("scaled.wgsl"), "\n```")]
pub const SCALED: &str = text(include_str!("scaled.wgsl"));

/// Airlight from two lookups in a [`Table`](crate::Table). Needs [`SCALED`].
///
/// ```wgsl
/// fn air_table_airlight(sigma_t: f32, segment: air_Segment) -> f32
/// ```
///
/// `A` in 1/(m sr), the airlight per unit of `σ_s I`, for the extinction `sigma_t` in 1/m.
/// The radiance in W/(m² sr) is `σ_s I A`, with the scattering σ_s in 1/m and the
/// radiant intensity I in W/sr, by colour channel. The relative error is
/// [`Table::error_bound`](crate::Table::error_bound) and what
/// the [module](crate::gpu#agreement-with-the-cpu) says of the device's arithmetic; a
/// segment that contains the light gives `air_FAR`, one without a result 0.
///
/// # To be written by the shader around it
///
/// ```wgsl
/// fn air_table_uniforms() -> air_Table
/// fn air_table_cell(index: u32) -> vec4<u32>
/// ```
///
/// The first returns [`Table::gpu_uniforms`](crate::Table::gpu_uniforms), usually a
/// `var<uniform>`; the second an entry of [`Table::gpu_cells`](crate::Table::gpu_cells),
/// usually of a storage buffer. Entries must stay integers on their way: not all of them
/// are numbers.
///
/// # Source
///
#[doc = concat!("```wgsl\n", include_str!("table.wgsl"), "\n```")]
pub const TABLE: &str = text(include_str!("table.wgsl"));

/// Nodes for integrands of one's own: [`Quadrature::nodes`](crate::Quadrature::nodes).
/// Needs [`SCALED`].
///
/// ```wgsl
/// struct air_Node {
///     distance: f32,
///     weight: f32,
///     one_minus_cos: f32,
///     one_plus_cos: f32,
///     depth: f32,
///     done: bool,
/// }
/// fn air_nodes(sigma_t: f32, segment: air_Segment) -> air_Nodes
/// fn air_next_node(nodes: ptr<function, air_Nodes>) -> air_Node
/// ```
///
/// A node lies `distance` metres from the start of the segment and has a `weight` in 1/m,
/// so that Σ weight f ≈ ∫ f / d² dx, with `d` the distance from the light. The phase
/// function takes `one_minus_cos` and `one_plus_cos`. `depth` is by how much more optical
/// depth light loses that is scattered at the node than light that is scattered at the
/// start of the segment. `done` says that this is no node and there are no more:
///
/// ```wgsl
/// var nodes = air_nodes(sigma_t, segment);
/// loop {
///     let node = air_next_node(&nodes);
///     if node.done { break; }
///     sum += node.weight * f(segment.x + node.distance);
/// }
/// ```
///
/// `f` contains everything but 1/d²: phase function, extinction, visibility, emission. The
/// error is the tolerance of the quadrature for an `f` of phase function and extinction.
///
/// ```wgsl
/// struct air_Pattern {
///     extra: u32,
///     deeper: f32,
///     range: f32,
/// }
/// fn air_pattern_nodes(sigma_t: f32, segment: air_Segment, pattern: air_Pattern) -> air_Nodes
/// ```
///
/// For a light with a pattern: how many nodes more each piece gets (`air_EXTRA_COSINE`,
/// `air_EXTRA_SPOT`, `air_EXTRA_FADING`, added up), how much deeper it is looked
/// (`air_DEEPER`), and the range in metres towards which the light fades, or 0. See
/// [`Quadrature::nodes_of`](crate::Quadrature::nodes_of). The shader divides the segment at
/// the rims of the light and has the emission in its `f`.
///
/// # To be written by the shader around it
///
/// ```wgsl
/// fn air_quadrature_uniforms() -> air_Quadrature
/// fn air_quadrature_entry(index: u32) -> vec4<f32>
/// ```
///
/// What [`Quadrature::gpu_uniforms`](crate::Quadrature::gpu_uniforms) returns, and an entry
/// of [`Quadrature::gpu_entries`](crate::Quadrature::gpu_entries).
///
/// # Source
///
#[doc = concat!("```wgsl\n", include_str!("nodes.wgsl"), "\n```")]
pub const NODES: &str = text(include_str!("nodes.wgsl"));

/// Airlight by a [`Quadrature`](crate::Quadrature). Needs [`PHASE`] and [`NODES`], and what
/// the latter asks for.
///
/// ```wgsl
/// fn air_quadrature_airlight(sigma_t: f32, segment: air_Segment) -> f32
/// ```
///
/// The same question and the same answers as `air_table_airlight` of [`TABLE`], within the
/// tolerance of the quadrature.
///
/// # Source
///
#[doc = concat!("```wgsl\n", include_str!("quadrature.wgsl"), "\n```")]
pub const QUADRATURE: &str = text(include_str!("quadrature.wgsl"));

/// Airlight from the table that was published in 2005, [`SunTable`](crate::SunTable), for
/// comparison. Needs [`NUMERIC`].
///
/// ```wgsl
/// fn air_sun_table_airlight(sigma_t: f32, segment: air_Segment) -> f32
/// ```
///
/// The same question as that of [`TABLE`], for isotropic fog; its error has no bound.
///
/// # To be written by the shader around it
///
/// ```wgsl
/// fn air_sun_table_rows() -> f32
/// fn air_sun_table_value(index: u32) -> f32
/// ```
///
/// What [`SunTable::gpu_rows`](crate::SunTable::gpu_rows) returns, and an entry of
/// [`SunTable::gpu_values`](crate::SunTable::gpu_values).
///
/// # Source
///
#[doc = concat!("```wgsl\n", include_str!("sun_table.wgsl"), "\n```")]
pub const SUN_TABLE: &str = text(include_str!("sun_table.wgsl"));

/// Airlight from a table of one frame, [`FrameTable`](crate::FrameTable). Needs [`SEGMENT`].
///
/// ```wgsl
/// fn air_frame_look_up(table: air_FrameTable, segment: air_Segment) -> f32
/// ```
///
/// `A` as in [`TABLE`], for parts of rays from the eye of the table in the medium of the
/// table; `air_FRAME_UNKNOWN`, which is negative, for what the table does not know: take
/// another evaluator there. `table` is a [`FrameTableRecord`](super::FrameTableRecord).
///
/// # To be written by the shader around it
///
/// ```wgsl
/// fn air_frame_cell(index: u32) -> vec4<f32>
/// ```
///
/// An entry of [`FrameTable::gpu_cells`](crate::FrameTable::gpu_cells).
///
/// # Source
///
#[doc = concat!("```wgsl\n", include_str!("frame_table.wgsl"), "\n```")]
pub const FRAME_TABLE: &str = text(include_str!("frame_table.wgsl"));

/// Light that reaches a surface by way of the fog: the tables of
/// [`surface`](crate::surface), which has the formula that they are for. Needs no other
/// part.
///
/// ```wgsl
/// fn air_lobe(optical_distance: f32, cos_theta: f32) -> f32
/// ```
///
/// `G_n(T, θ)`, dimensionless, by a [`LobeTable`](crate::surface::LobeTable), which is for
/// one exponent `n`: at the optical distance T ≥ 0 of the light and the cosine of the angle
/// between light and lobe, within 1e-4 of itself and what the device's logarithm and
/// exponential add: 4e-5 and some 3 (1 + T) units of the last digit.
///
/// ```wgsl
/// fn air_gloss(exponent: f32, optical_distance: f32, cos_theta: f32) -> f32
/// ```
///
/// The same for any exponent from 1 to 200, by a
/// [`GlossTable`](crate::surface::GlossTable).
///
/// # To be written by the shader around it
///
/// ```wgsl
/// fn air_surface_coefficient(index: u32) -> f32
/// ```
///
/// An entry of [`LobeTable::coefficients`](crate::surface::LobeTable::coefficients) for the
/// one, of [`GlossTable::coefficients`](crate::surface::GlossTable::coefficients) for the
/// other.
///
/// # Source
///
#[doc = concat!("```wgsl\n", include_str!("surface.wgsl"), "\n```")]
pub const SURFACE: &str = text(include_str!("surface.wgsl"));

/// The text itself. A call keeps it out of the line in which the documentation shows the
/// constant.
const fn text(source: &'static str) -> &'static str {
    source
}

#[cfg(test)]
mod tests {
    use gpu_backend::testing::Shader;

    use super::*;

    const DATA: &str = "
        fn air_table_uniforms() -> air_Table { return air_Table(); }
        fn air_table_cell(index: u32) -> vec4<u32> { return vec4(index); }
        fn air_quadrature_uniforms() -> air_Quadrature { return air_Quadrature(); }
        fn air_quadrature_entry(index: u32) -> vec4<f32> { return vec4(f32(index)); }
        fn air_sun_table_rows() -> f32 { return 1.0; }
        fn air_sun_table_value(index: u32) -> f32 { return f32(index); }
        fn air_frame_cell(index: u32) -> vec4<f32> { return vec4(f32(index)); }
        fn air_surface_coefficient(index: u32) -> f32 { return f32(index); }";

    #[test]
    fn pages_say_what_the_parts_define() {
        let parts = [
            PHASE,
            SEGMENT,
            NUMERIC,
            SCALED,
            TABLE,
            NODES,
            QUADRATURE,
            SUN_TABLE,
            FRAME_TABLE,
            SURFACE,
            DATA,
        ];
        let named = Shader::documented(&parts, include_str!("parts.rs")).unwrap();
        // Whatever the shader around the parts must write, and what it comes for.
        for part in [DATA, SEGMENT, QUADRATURE] {
            let functions = part.lines().map(str::trim_start);
            for function in functions.filter_map(|line| line.strip_prefix("fn ")) {
                let name = function.split('(').next().unwrap_or_default();
                assert!(named.iter().any(|other| other == name), "{name}");
            }
        }
        // Without signatures of the table the page would have said nothing.
        assert!(named.len() > 25, "{named:?}");
    }
}
