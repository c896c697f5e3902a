!> What a CONTact block says, before its surfaces are built.
module contact_spec
  use base_kinds, only: wp
  use base_error, only: place_t
  use contact_pair, only: bond_t
  use contact_type, only: contact_law_t, MAX_LAW_PROP
  use input_where, only: where_t
  implicit none
  private
  public :: contact_spec_t, spec_law_t

  !> One law and its numbers.
  type :: spec_law_t
    logical :: given = .false.
    type(contact_law_t) :: row
    real(wp) :: prop(MAX_LAW_PROP) = 0.0_wp
    logical :: auto = .false.          !! its penalty comes from stiffness and element size
    real(wp) :: factor = 1.0_wp        !! of AUTO
    real(wp) :: tau = 0.0_wp           !! of VISCous [T]; 0: none
  end type spec_law_t

  type :: contact_spec_t
    character(:), allocatable :: name
    type(place_t) :: place
    type(where_t) :: at(2)             !! SURFaces
    type(spec_law_t) :: normal, friction, cohesive
    logical :: on_pair = .false.       !! PAIR
    type(place_t) :: pair_place        !! of the word
    real(wp) :: border = 0.0_wp        !! BORDer, share of an element
    logical :: balanced = .false.      !! BALAnced
    logical :: has_after = .false.
    real(wp) :: after = 0.0_wp         !! AFTEr [T]
    type(bond_t), allocatable :: bond(:)
    real(wp) :: bond_gap = -1.0_wp     !! [L]
    type(place_t) :: bond_place        !! of the first BONDed; no file: there is none
    real(wp) :: depth = 0.0_wp         !! [L] 0: the default
    integer :: n(2) = 5                !! integration points of an element in its two directions
    integer :: ncell = 1               !! REFIne: cells a direction of an element that is cut
    type(place_t) :: refine_place      !! of the word
  end type contact_spec_t

end module contact_spec
