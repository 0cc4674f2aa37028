// The light of all lit parts of a path.
//
// Needs, from the entry point, the light of one part; it is called for the parts in order:
//   fn light_of_part(path: light_Path, part: light_Lit) -> vec3<f32>

// If `joined`, parts that touch and see the same share of the light count as one.
fn light_of_parts(path: light_Path, joined: bool) -> vec3<f32> {
    var cursor = light_cursor(path);
    // The last part that was found and has not been evaluated yet.
    var part = light_dark();
    var sum = vec3(0.0);
    loop {
        let next = light_next_lit(&cursor, path);
        let is_last = light_is_dark(next);
        let is_same = all(next.visibility == part.visibility);
        if joined && !is_last && is_same && next.start == part.end {
            part.end = next.end;
            continue;
        }
        if !light_is_dark(part) {
            sum += light_of_part(path, part);
        }
        if is_last {
            break;
        }
        part = next;
    }
    return sum;
}
