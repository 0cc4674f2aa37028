//! The questions that parts of a shader answer.

use gpu_backend::shader::Slot;

/// The slot for the question: *which parts of this ray are lit?* With the types of
/// [`LIT`](super::LIT), a part `x` defines
///
/// ```wgsl
/// struct x_Cursor                                   its state along one ray
/// fn x_cursor(path: light_Path) -> x_Cursor
/// fn x_next_lit(cursor: ptr<function, x_Cursor>, path: light_Path) -> light_Lit
/// ```
///
/// and yields the lit parts of the path in order, and then `light_dark()`.
#[derive(Debug, Clone, Copy)]
pub struct VisibilitySlot;

impl Slot for VisibilitySlot {
    fn glue(part: &str) -> String {
        visibility(part, ["light_Cursor", "light_cursor", "light_next_lit"])
    }
}

/// The first source of [`Both`](crate::visibility::Both).
pub(super) struct First;

impl Slot for First {
    fn glue(part: &str) -> String {
        let names = ["FirstCursor", "first", "next_first"];
        visibility(part, names.map(|name| format!("light_both_{name}")))
    }
}

/// Its second source.
pub(super) struct Second;

impl Slot for Second {
    fn glue(part: &str) -> String {
        let names = ["SecondCursor", "second", "next_second"];
        visibility(part, names.map(|name| format!("light_both_{name}")))
    }
}

/// The source of shadows of a [`Textured`](crate::methods::textured::Textured) light.
#[cfg(feature = "shadow-map")]
pub(crate) struct Shadows;

#[cfg(feature = "shadow-map")]
impl Slot for Shadows {
    fn glue(part: &str) -> String {
        let names = ["Shadows", "shadows", "next_shadows"];
        visibility(part, names.map(|name| format!("light_textured_{name}")))
    }
}

fn visibility<S: std::fmt::Display>(part: &str, [cursor, start, next]: [S; 3]) -> String {
    format!(
        "
alias {cursor} = {part}_Cursor;
fn {start}(path: light_Path) -> {cursor} {{
    return {part}_cursor(path);
}}
fn {next}(cursor: ptr<function, {cursor}>, path: light_Path) -> light_Lit {{
    return {part}_next_lit(cursor, path);
}}
"
    )
}

/// The slot for the question: *how much light arrives from this part of a ray?* A part `x`
/// defines
///
/// ```wgsl
/// fn x_airlight(path: light_Path, start: f32, end: f32) -> vec3<f32>
/// ```
///
/// which returns the radiance from an interval, all of which is lit.
#[derive(Debug, Clone, Copy)]
pub struct AirlightSlot;

impl Slot for AirlightSlot {
    fn glue(part: &str) -> String {
        format!(
            "
fn light_airlight(path: light_Path, start: f32, end: f32) -> vec3<f32> {{
    return {part}_airlight(path, start, end);
}}
"
        )
    }
}

/// The slot for the question: *which share of the light reaches this point?* A part `x` defines
///
/// ```wgsl
/// fn x_visibility(point: vec3<f32>) -> vec3<f32>
/// ```
///
/// which returns the share of each colour, from 0 to 1.
#[derive(Debug, Clone, Copy)]
pub struct PointSlot;

impl Slot for PointSlot {
    fn glue(part: &str) -> String {
        visibility_at(part, "light_point_visibility")
    }
}

/// The slot for the question: *which share of the light reaches this step of a ray, on
/// average?* A part `x` defines
///
/// ```wgsl
/// fn x_between(start: vec3<f32>, end: vec3<f32>) -> vec3<f32>
/// ```
///
/// which returns the share of each colour, from 0 to 1, along the way between two points.
#[derive(Debug, Clone, Copy)]
pub struct StepSlot;

impl Slot for StepSlot {
    fn glue(part: &str) -> String {
        format!(
            "
fn light_step_visibility(start: vec3<f32>, end: vec3<f32>) -> vec3<f32> {{
    return {part}_between(start, end);
}}
"
        )
    }
}

/// The first source of [`Both`](crate::visibility::Both) that is asked at a point.
pub(super) struct FirstPoint;

impl Slot for FirstPoint {
    fn glue(part: &str) -> String {
        visibility_at(part, "light_both_first_visibility")
    }
}

/// Its second source.
pub(super) struct SecondPoint;

impl Slot for SecondPoint {
    fn glue(part: &str) -> String {
        visibility_at(part, "light_both_second_visibility")
    }
}

fn visibility_at(part: &str, name: &str) -> String {
    format!(
        "
fn {name}(point: vec3<f32>) -> vec3<f32> {{
    return {part}_visibility(point);
}}
"
    )
}

/// The first source of [`Both`](crate::visibility::Both) that is asked about surfaces.
pub(super) struct FirstSurface;

impl Slot for FirstSurface {
    fn glue(part: &str) -> String {
        visibility_on(part, "light_both_first_on_surface")
    }
}

/// Its second source.
pub(super) struct SecondSurface;

impl Slot for SecondSurface {
    fn glue(part: &str) -> String {
        visibility_on(part, "light_both_second_on_surface")
    }
}

pub(crate) fn visibility_on(part: &str, name: &str) -> String {
    format!(
        "
fn {name}(point: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {{
    return {part}_on_surface(point, normal);
}}
"
    )
}
