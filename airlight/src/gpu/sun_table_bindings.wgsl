// A table of Sun et al. in a group of its own.

@group(1) @binding(0) var<uniform> air_rows: f32;
@group(1) @binding(1) var<storage> air_values: array<f32>;

fn air_sun_table_rows() -> f32 {
    return air_rows;
}

fn air_sun_table_value(index: u32) -> f32 {
    return air_values[index];
}

fn air_airlight(sigma_t: f32, segment: air_Segment) -> f32 {
    return air_sun_table_airlight(sigma_t, segment);
}
