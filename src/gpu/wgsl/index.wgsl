// Numbers of workgroups and of invocations in a dispatch, which may have several rows of workgroups.

fn own_group(group: vec3<u32>) -> u32 {
    return group.y * ACROSS + group.x;
}

fn own_index(group: vec3<u32>, lane: u32) -> u32 {
    return own_group(group) * GROUP + lane;
}
