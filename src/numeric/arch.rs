//! Which instructions to dispatch to.

use pulp::Arch;

/// The best that the machine has with registers of at most 256 bits.
///
/// For jobs whose lanes are arrays of one such register or two, whatever the machine has: LLVM joins those to registers
/// of 512 bits where there are some, which takes more shuffles than it saves operations.
pub(crate) fn arch_256() -> Arch {
    match Arch::new() {
        #[cfg(target_arch = "x86_64")]
        Arch::V4(v4) => Arch::V3(*v4),
        arch => arch,
    }
}
