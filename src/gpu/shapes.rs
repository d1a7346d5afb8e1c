//! Faces by their surroundings: those with the same ones share their tables of weights.

use super::deciding::nets;
use super::dicer::{Dicer, Shown};
use super::error::GpuError;
use super::surroundings::{Finder, Surroundings};
use super::{tables, uv_tables};
use crate::frame::Drawing;
use crate::limits::Budget;
use crate::topology::NONE;
use std::collections::HashMap;

/// Shapes by what makes them different, numbered in the order in which they are met.
#[derive(Default)]
struct Shapes {
    numbers: HashMap<Vec<u32>, u32>,
    all: Vec<Surroundings>,
}

impl Shapes {
    /// The number of a shape, and the bytes that it takes where it is new.
    fn number(&mut self, key: Vec<u32>, shape: &Surroundings) -> (u32, usize) {
        let next = self.all.len() as u32;
        let bytes = shape.bytes() + size_of_val(&*key);
        let number = *self.numbers.entry(key).or_insert(next);
        if number != next {
            return (number, 0);
        }
        self.all.push(shape.clone());
        (number, bytes)
    }
}

impl Dicer<'_> {
    /// Makes the tables of faces that are to be known at these levels, and their control points as B-splines.
    pub(super) fn make_tables(
        &mut self,
        needs: &[u32],
        drawing: Drawing,
        has_nets: bool,
        budget: &mut Budget<'_>,
    ) -> Result<(), GpuError> {
        /// Faces between two looks at the budget.
        const FACES: usize = 1024;
        let finder = Finder::new(self.surface);
        let (mut shapes, mut uv_shapes) = (Shapes::default(), Shapes::default());
        let mut levels: Vec<u32> = Vec::new();
        // Faces with texture coordinates, and the numbers of their shapes.
        let mut uv_faces: Vec<[u32; 2]> = Vec::new();
        let mut color_faces: Vec<[u32; 2]> = Vec::new();
        let mut bytes = 0;
        for (face, &need) in (0..).zip(needs) {
            if (face as usize).is_multiple_of(FACES) {
                let taken = std::mem::take(&mut bytes) as u128;
                budget.take("the faces of the GPU backend", taken, 0)?;
            }
            if need == NONE {
                continue;
            }
            let found = finder.find(face);
            let (shape, new) = shapes.number(found.key(), &found);
            bytes += new;
            match levels.get_mut(shape as usize) {
                Some(level) => *level = need.max(*level),
                None => levels.push(need),
            }
            let is_drawn = self.drawn_levels.contains_key(&face);
            if self.own_colors && is_drawn {
                color_faces.push([face, shape]);
            }
            if self.look.textured && is_drawn || self.lifts_by_uvs() {
                let (shape, new) = uv_shapes.number(found.uv_key(), &found);
                bytes += new;
                uv_faces.push([face, shape]);
            }
            let places = found.into_places(shape);
            bytes += places.bytes();
            self.faces.insert(face, places);
        }
        budget.take("the faces of the GPU backend", bytes as u128, 0)?;
        let wanted: Vec<_> = shapes.all.iter().zip(levels).collect();
        if !self.is_apart() {
            self.tables = tables::make(self.surface, &wanted, drawing, self.look.width, budget)?;
        }
        if has_nets {
            let all = shapes.all.iter().map(|shape| nets(self.surface, shape));
            self.nets = all.collect::<Result<_, _>>()?;
        }
        if self.shown == Shown::Qas {
            self.base_tables = tables::make_base(self.surface, &wanted, self.look.width, budget)?;
        }
        let (numbers, wanted) = self.numbered(&color_faces, &shapes.all);
        self.color_numbers = numbers;
        self.color_tables = tables::make(
            self.surface,
            &wanted,
            Drawing::Limit,
            self.color_width(),
            budget,
        )?;
        let (numbers, wanted) = self.numbered(&uv_faces, &uv_shapes.all);
        self.uv_numbers = numbers;
        self.uv_tables = uv_tables::make_uvs(self.surface, &wanted, self.look.uv_width, budget)?;
        Ok(())
    }

    /// Tables of values beside points, as fine as what is drawn: the number of each of `faces`, which come with their shapes, and what tables
    /// are wanted.
    fn numbered<'s>(
        &self,
        faces: &[[u32; 2]],
        shapes: &'s [Surroundings],
    ) -> (HashMap<u32, u32>, Vec<tables::Wanted<'s>>) {
        let mut numbers: HashMap<[u32; 2], u32> = HashMap::new();
        let mut wanted: Vec<tables::Wanted<'s>> = Vec::new();
        let mut of_faces = HashMap::new();
        for &[face, shape] in faces {
            let level = match self.is_apart() {
                true => self.drawn_levels[&face],
                false => self.tables[self.faces[&face].shape as usize].level,
            };
            let next = wanted.len() as u32;
            let number = *numbers.entry([shape, level]).or_insert(next);
            if number == next {
                wanted.push((&shapes[shape as usize], level));
            }
            of_faces.insert(face, number);
        }
        (of_faces, wanted)
    }
}
