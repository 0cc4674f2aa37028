//! Airlight evaluators in shaders.

use airlight::Table;
use airlight::gpu::{FRAME_TABLE, FrameTableRecord, NODES, NUMERIC, SCALED, SEGMENT, TABLE};
use gpu_backend::gpu::{Argument, InShader};
use gpu_backend::shader::Part;

use super::AirlightSlot;
use crate::airlight::{Analytic, Daylight, EquiAngular, Midpoint, PerFrame, Quadrature};

impl InShader<AirlightSlot> for Midpoint {
    fn part() -> Part {
        Part::new("light_midpoint").source(include_str!("midpoint.wgsl"))
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        Vec::new()
    }
}

impl InShader<AirlightSlot> for Daylight {
    fn part() -> Part {
        Part::new("light_daylight")
            .uniform("light_daylight_distance", "f32")
            .source(include_str!("daylight.wgsl"))
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        vec![Argument::uniform(self.distance())]
    }
}

impl InShader<AirlightSlot> for EquiAngular {
    fn part() -> Part {
        Part::new("light_equi_angular")
            .source(include_str!("equi_angular.wgsl"))
            .uniform("light_node_count", "u32")
            .read("light_nodes", "array<vec2<f32>>")
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let nodes: Vec<[f32; 2]> = self.rule().iter().map(|(t, w)| [*t, *w]).collect();
        vec![Argument::uniform(self.nodes()), Argument::table(&nodes)]
    }
}

impl InShader<AirlightSlot> for Quadrature {
    fn part() -> Part {
        Part::new("light_quadrature")
            .sources(&[SEGMENT, NUMERIC, SCALED, NODES])
            .source(include_str!("cookie.wgsl"))
            .source(include_str!("quadrature.wgsl"))
            .uniform("light_rules", "air_Quadrature")
            .read("light_rule_entries", "array<vec4<f32>>")
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        vec![
            Argument::uniform(self.rule().gpu_uniforms()),
            Argument::table(&self.rule().gpu_entries()),
        ]
    }
}

/// WGSL of what the evaluators of plain points have in common.
const BY_CONE: &str = include_str!("by_cone.wgsl");

impl InShader<AirlightSlot> for Analytic<Table> {
    fn part() -> Part {
        Part::new("light_analytic")
            .with(Quadrature::part())
            .sources(&[TABLE, BY_CONE, include_str!("analytic.wgsl")])
            .uniform("light_table", "air_Table")
            .read("light_table_cells", "array<vec4<u32>>")
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let mut arguments = self.fallback().arguments();
        arguments.push(Argument::uniform(self.evaluator().gpu_uniforms()));
        arguments.push(Argument::table(&self.evaluator().gpu_cells()));
        arguments
    }
}

impl InShader<AirlightSlot> for PerFrame {
    fn part() -> Part {
        Part::new("light_per_frame")
            .with(Quadrature::part())
            .sources(&[FRAME_TABLE, BY_CONE, include_str!("per_frame.wgsl")])
            .uniform("light_frame_tables", "array<air_FrameTable, 3>")
            .read("light_frame_cells", "array<vec4<f32>>")
    }

    fn arguments(&self) -> Vec<Argument<'_>> {
        let mut records = [FrameTableRecord::default(); 3];
        let mut cells = Vec::new();
        for (record, table) in records.iter_mut().zip(self.tables()) {
            *record = table.gpu_record(cells.len() as u32);
            cells.extend_from_slice(table.gpu_cells());
        }
        if cells.is_empty() {
            // Buffers have a length.
            cells.push([0.0; 4]);
        }
        let mut arguments = self.fallback().arguments();
        arguments.push(Argument::uniform(records));
        arguments.push(Argument::table(&cells));
        arguments
    }
}
