// A table of Sun et al. that is bound by itself. Needs the variables
//   air_rows: f32
//   air_values: array<f32>

fn air_sun_table_rows() -> f32 {
    return air_rows;
}

fn air_sun_table_value(index: u32) -> f32 {
    return air_values[index];
}
