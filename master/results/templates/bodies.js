// Bodies on their meshes: displacements, motion, the cut through the block, and what colours them.

// a mesh of the page as arrays: coordinates [m], corners of triangles, mode shapes
async function unpackMesh(mesh) {
  const buffers = [mesh.points, mesh.triangles, mesh.modes].map(inflate);
  const [points, triangles, modes] = await Promise.all(buffers);
  return {
    points: new Float32Array(points),
    triangles: new Uint32Array(triangles),
    modes: Float32Array.from(new Int16Array(modes), value => value / 32767),
  };
}

// displacement of every point at a recorded instant: modes times modal coordinates
function displaced(solid, { points, modes }, frame) {
  const size = points.length, displacement = new Float64Array(size), coordinates = column(solid.coordinates);
  for (let k = 0; k < solid.count; k++) {
    const coordinate = coordinates[frame * solid.count + k];
    for (let p = 0; p < size; p++) displacement[p] += coordinate * modes[k * size + p];
  }
  return displacement;
}

// sizes of displacements [µm]
function sizesOf(displacement) {
  const sizes = new Float32Array(displacement.length / 3);
  for (let p = 0; p < sizes.length; p++)
    sizes[p] = 1e6 * Math.hypot(displacement[3 * p], displacement[3 * p + 1], displacement[3 * p + 2]);
  return sizes;
}

// points after the motion of the body; displacement, motion across and tilt are drawn so many times
function placed(solid, mesh, displacement, frame, times) {
  const scale = solid.schematic ? 1 : times, out = new Float32Array(mesh.points.length);
  const [across, along, turn] = solid.motion ? column(solid.motion).subarray(3 * frame, 3 * frame + 3) : [0, 0, 0];
  const c = Math.cos(scale * turn), s = Math.sin(scale * turn);
  for (let p = 0; p < out.length; p += 3) {
    const x = mesh.points[p] + scale * displacement[p], y = mesh.points[p + 1] + scale * displacement[p + 1];
    out[p] = c * x - s * y + scale * across;
    out[p + 1] = s * x + c * y + along;
    out[p + 2] = mesh.points[p + 2] + scale * displacement[p + 2];
  }
  return out;
}

// The half of a mesh behind z = 0: its triangles, and points on the cut as [point, point, share of the second].
function cutOpen(mesh) {
  const count = mesh.points.length / 3, between = [], known = new Map(), triangles = [];
  const z = point => mesh.points[3 * point + 2];
  const pointOnCut = (a, b) => {
    const [first, second] = a < b ? [a, b] : [b, a], edge = first * count + second;
    if (!known.has(edge)) {
      known.set(edge, count + between.length);
      between.push([first, second, z(first) / (z(first) - z(second))]);
    }
    return known.get(edge);
  };
  for (let t = 0; t < mesh.triangles.length; t += 3) {
    const polygon = [];
    for (let k = 0; k < 3; k++) {
      const a = mesh.triangles[t + k], b = mesh.triangles[t + (k + 1) % 3];
      if (z(a) <= 0) polygon.push(a);
      if (z(a) <= 0 !== z(b) <= 0) polygon.push(pointOnCut(a, b));
    }
    for (let k = 2; k < polygon.length; k++) triangles.push(polygon[0], polygon[k - 1], polygon[k]);
  }
  return { between, triangles: Uint32Array.from(triangles) };
}

// values of the points, `size` for each, then those of the points on the cut
function withCut(values, between, size) {
  if (!between.length) return values;
  const count = values.length / size, out = new Float32Array(values.length + size * between.length);
  out.set(values);
  between.forEach(([a, b, share], k) => {
    for (let c = 0; c < size; c++)
      out[size * (count + k) + c] = (1 - share) * values[size * a + c] + share * values[size * b + c];
  });
  return out;
}

// whether a surface encloses a body (each edge belongs to two triangles, once in each direction), and whether its
// triangles are counterclockwise from outside
function enclosing({ points, triangles }) {
  const edges = new Set(), count = points.length / 3;
  let volume = 0;
  for (let t = 0; t < triangles.length; t += 3) {
    const corners = triangles.subarray(t, t + 3);
    const [a, b, c] = [...corners].map(point => points.subarray(3 * point, 3 * point + 3));
    for (let k = 0; k < 3; k++) edges.add(corners[k] * count + corners[(k + 1) % 3]);
    volume += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2])
      + a[2] * (b[0] * c[1] - b[1] * c[0]);
  }
  const reverse = edge => edge % count * count + Math.floor(edge / count);
  const closed = edges.size === triangles.length && [...edges].every(edge => edges.has(reverse(edge)));
  return { closed, outward: volume > 0 };
}

// for every point the cell of a field around the body between two heights, -1 where it is not on that face
function cellsOf(mesh, run, [low, high]) {
  const [n, m] = run.shape, [start] = run.ends[0], count = mesh.points.length / 3;
  const radii = Float64Array.from({ length: count }, (_, p) => Math.hypot(mesh.points[3 * p], mesh.points[3 * p + 2]));
  const outermost = d3.max(radii);
  return Int32Array.from({ length: count }, (_, p) => {
    const [x, y, z] = mesh.points.subarray(3 * p, 3 * p + 3), share = (y - low) / (high - low);
    if (radii[p] < 0.985 * outermost || share < -1e-6 || share > 1 + 1e-6) return -1;
    const angle = Math.atan2(x, z) * 180 / Math.PI;   // from +z towards +x
    const i = ((Math.floor((angle - start) / 360 * n) % n) + n) % n;
    const cell = i * m + Math.min(m - 1, Math.max(0, Math.floor(share * m)));
    return has(run, cell) ? cell : -1;
  });
}

// What bodies can be coloured by: name, unit, range of all instants and runs, values at the points of a body (null
// without any, NaN at a point without one), and the fields to read first.
function colourings(scenes) {
  const solids = scenes.flatMap(scene => scene.solids), known = [...fieldColourings(scenes)];
  const stressed = solids.map(solid => solid.stress).filter(Boolean);
  if (stressed.length) known.push({
    name: "von Mises stress", unit: "MPa", ...rangeOf(stressed), fields: stressed,
    values: (scene, k, frame, sizes) => {
      const { stress } = scene.solids[k];
      return stress && sizes.map((_, p) => stress.at(frame, p));
    },
  });
  for (const name of new Set(solids.filter(solid => solid.count).map(solid => solid.name))) known.push({
    name: `displacement of the ${name}`, unit: "µm", fields: [],
    low: 0, high: 1e6 * d3.max(solids.filter(solid => solid.name === name), solid => solid.largest),
    values: (scene, k, frame, sizes) => scene.solids[k].name === name && scene.solids[k].count ? sizes : null,
  });
  return known.length ? known : [{ name: "nothing", unit: "", low: 0, high: 1, fields: [], values: () => null }];
}

const rangeOf = ranges => ({ low: d3.min(ranges, range => range.low), high: d3.max(ranges, range => range.high) });

// recorded fields that lie around bodies; those of one kind on several films have one colouring
function fieldColourings(scenes) {
  const layers = data.films.flatMap(film => Object.values(film.layers));
  const isDrawn = (_, f) =>
    scenes.some(({ run, solids }) => layers[f].runs[run] && solids.some(solid => solid.over[f]));
  const drawn = d3.range(layers.length).filter(isDrawn);
  return [...d3.group(drawn, f => layers[f].variable)].map(([name, own]) => {
    const fields = own.map(f => layers[f]);
    const values = (scene, k, frame, sizes) => {
      const solid = scene.solids[k], found = sizes.map(() => NaN);
      for (const f of own) {
        const run = layers[f].runs[scene.run];
        if (!run || !solid.over[f]) continue;
        const cells = (solid.cells ||= {})[f] ||= cellsOf(scene.meshes[k], run, solid.over[f]);
        cells.forEach((cell, p) => {
          if (cell >= 0) found[p] = run.at(frame, cell);
        });
      }
      return found;
    };
    const { unit } = fields[0], runs = fields.flatMap(field => field.runs.filter(Boolean));
    return { name, unit, ...rangeOf(fields), fields: runs, values };
  }).filter(({ low, high }) => low < high);
}
