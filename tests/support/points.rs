//! Distances between points and between sets of points.

/// Length of the diagonal of the bounding box.
pub fn extent(points: &[[f64; 3]]) -> f64 {
    let mut sum = 0.0;
    for k in 0..3 {
        let lo = points.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min);
        let hi = points
            .iter()
            .map(|p| p[k])
            .fold(f64::NEG_INFINITY, f64::max);
        sum += (hi - lo).powi(2);
    }
    sum.sqrt()
}

pub fn distance<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    (0..N).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// Points sorted for nearest-neighbour search within a small radius.
pub struct PointSet<'a, const N: usize> {
    points: &'a [[f64; N]],
    order: Vec<usize>,
    axis: usize,
}

impl<'a, const N: usize> PointSet<'a, N> {
    pub fn new(points: &'a [[f64; N]]) -> Self {
        let spread = |k: usize| {
            let mut c: Vec<i64> = points.iter().map(|p| (p[k] * 1e6) as i64).collect();
            c.sort_unstable();
            c.dedup();
            c.len()
        };
        let axis = (0..N).max_by_key(|&k| spread(k)).unwrap();
        let mut order: Vec<usize> = (0..points.len()).collect();
        order.sort_by(|&a, &b| points[a][axis].total_cmp(&points[b][axis]));
        Self {
            points,
            order,
            axis,
        }
    }

    /// All points within `radius` of `p`.
    pub fn near(&self, p: &[f64; N], radius: f64) -> Vec<usize> {
        let k = self.axis;
        let start = self
            .order
            .partition_point(|&i| self.points[i][k] < p[k] - radius);
        self.order[start..]
            .iter()
            .copied()
            .take_while(|&i| self.points[i][k] <= p[k] + radius)
            .filter(|&i| distance(&self.points[i], p) <= radius)
            .collect()
    }

    /// Distance of `p` to the nearest point, infinite beyond `radius`.
    pub fn nearest(&self, p: &[f64; N], radius: f64) -> f64 {
        self.near(p, radius)
            .into_iter()
            .map(|i| distance(&self.points[i], p))
            .fold(f64::INFINITY, f64::min)
    }
}

/// Largest distance of a point of one set to the other set, both ways; infinite beyond `radius`.
pub fn set_distance<const N: usize>(a: &[[f64; N]], b: &[[f64; N]], radius: f64) -> f64 {
    let (sa, sb) = (PointSet::new(a), PointSet::new(b));
    let one = |p: &[[f64; N]], s: &PointSet<'_, N>| {
        p.iter().map(|p| s.nearest(p, radius)).fold(0.0, f64::max)
    };
    one(a, &sb).max(one(b, &sa))
}
