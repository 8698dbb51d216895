//! What stands for indirect light: Cycles' fast GI approximation.

use super::Walk;
use crate::effects::Features;
use crate::film::light_passes::PassSink;
use crate::integrator::record::Record;

impl<E: Features, A: PassSink + Record> Walk<'_, '_, E, A> {
    /// What the world's light is multiplied with, if the ray stands for all further bounces. As Cycles counts them
    /// (`path_state_ao_bounce`): passages through glass cost none, and of all reflections one costs none.
    #[cold]
    #[inline(never)]
    fn replaced(&self) -> Option<f32> {
        let (bounces, factor) = self.world.replaced_after()?;
        let [_, glossy, transmission] = self.beside.scatterings;
        let free = transmission + glossy.min(1);
        (self.bounce + 1 > bounces + free).then_some(factor)
    }

    /// Lets a ray that stands for all further bounces see no farther than what is near; whether it does. As in Cycles, the way begins
    /// where the path was scattered, and the last surface that it has passed says how long it is.
    #[cold]
    #[inline(never)]
    pub(super) fn shorten(&mut self) -> bool {
        let stands = self.replaced().is_some();
        if stands {
            let far = self.beside.reach - self.beside.walked;
            self.span.1 = self.span.1.min(far).max(self.span.0);
        }
        stands
    }

    /// What the light of the world is multiplied with that the ray brings.
    #[inline(always)]
    pub(super) fn world_share(&self) -> f32 {
        if E::EVERYTHING && self.world.is_approximated() {
            return self.replaced().unwrap_or(1.0);
        }
        1.0
    }

    /// Takes note of the object that the ray leaves.
    #[inline(always)]
    pub(super) fn leave_object(&mut self, object: Option<u32>) {
        if E::EVERYTHING && self.world.is_approximated() {
            self.beside.reach = self.world.reach(object);
        }
    }
}
