!> Supports, prescribed motion and loads, as given in the deck.
!!
!! Load number 0 stands for the sum of all load tables (as in FEAP), and k > 0 for table k.
module boundary
  use base_error, only: place_t
  use base_kinds, only: wp
  implicit none
  private
  public :: boundary_t, motion_t, pressure_t
  public :: note_load_number, place_of_number, moved_dofs

  !> Rigid motion of a set of nodes (MOVE). If a node has several motions, its reference position is
  !! rotated by all rotations in the order of the deck, and then all translations are added.
  type :: motion_t
    integer, allocatable :: node(:)
    logical :: rotates = .false.
    logical :: acts(3) = .true.      !! directions prescribed (`*` leaves one free)
    real(wp) :: vector(3) = 0.0_wp   !! translation [L], or a point on the axis
    real(wp) :: axis(3) = 0.0_wp     !! unit axis of rotation
    real(wp) :: angle = 0.0_wp       !! [rad] at factor 1
    integer :: table = 0
    type(place_t) :: place
  end type motion_t

  !> Normal pressure on element faces; p > 0 presses on the body.
  type :: pressure_t
    integer, allocatable :: block(:), elem(:), side(:)
    real(wp) :: value = 0.0_wp       !! [F/L^2]
    integer :: table = 0
    logical :: follower = .false.    !! acts on the current faces, not on the reference faces
    type(place_t) :: place
  end type pressure_t

  !> Forces that do not depend on the motion.
  type :: dead_load_t
    integer :: table = 0
    integer, allocatable :: node(:)
    real(wp), allocatable :: f(:, :) !! (3, size(node)) [F] at factor 1
    type(place_t) :: place           !! place of the first force
  end type dead_load_t

  !> A load number that the deck gives to nodes, and the place where it first occurs.
  type :: load_number_t
    integer :: table = 0
    type(place_t) :: place
  end type load_number_t

  type :: boundary_t
    integer, allocatable :: fixed(:, :)       !! (3, nnode) restraint code; not 0: prescribed
    real(wp), allocatable :: value(:, :) !! (3, nnode) prescribed displacement at factor 1 [L]
    !! (DISP, EDIS, CDIS)
    real(wp), allocatable :: force(:, :) !! (3, nnode) nodal force at factor 1 [F] (FORC, EFOR,
    !! CFOR, and the forces of CSUR)
    integer, allocatable :: table(:, :) !! (3, nnode) load number of value and force (FPRO, EPRO)
    logical, allocatable :: numbered(:)       !! (nnode) FPRO or EPRO gives the load numbers
    type(motion_t), allocatable :: motion(:)
    type(pressure_t), allocatable :: pressure(:)
    type(dead_load_t), allocatable :: dead(:) !! integrated body forces and dead pressures
    type(load_number_t), allocatable :: number(:) !! load numbers of FPRO and EPRO, each once
    integer, allocatable :: rival(:, :) !! (3, nnode) second load number where TIE joins nodes with
    !! different numbers; negative: none. Not allocated if no node has one.
    logical, allocatable :: split(:, :) !! (3, nnode) there are loads with both numbers
    type(place_t) :: tied                     !! place of the first TIE, if `rival` is allocated
    type(place_t), allocatable :: loose(:) !! records that prescribe displacements at dofs without a
    !! restraint, or at dofs that MOVE prescribes too
    integer, allocatable :: loose_kind(:) !! (size(loose)) LOOSE_FREE, ...
  end type boundary_t

  !> Where DISP, EDIS or CDIS gives a displacement: at a free dof, at a dof that MOVE prescribes, or
  !! at a dof that MOVE prescribes and that also has a restraint.
  integer, parameter, public :: LOOSE_FREE = 1, LOOSE_MOVED = 2, LOOSE_ADDED = 3

contains

  !> The dofs that MOVE prescribes.
  pure function moved_dofs(bc, nnode) result(moved)
    type(boundary_t), intent(in) :: bc
    integer, intent(in) :: nnode
    logical :: moved(3, nnode)
    integer :: j, m

    moved = .false.
    do m = 1, size(bc%motion)
      do j = 1, size(bc%motion(m)%node)
        where (bc%motion(m)%acts) moved(:, bc%motion(m)%node(j)) = .true.
      end do
    end do
  end function moved_dofs

  !> Record the place where a load number first occurs.
  subroutine note_load_number(bc, table, place)
    type(boundary_t), intent(inout) :: bc
    integer, intent(in) :: table
    type(place_t), intent(in) :: place
    type(load_number_t) :: new

    if (.not. allocated(bc%number)) allocate (bc%number(0))
    if (table == 0 .or. any(bc%number%table == table)) return
    new%table = table
    new%place = place
    bc%number = [bc%number, new]
  end subroutine note_load_number

  !> Find the place where a load number of nodes first occurs; the result is empty if the deck does
  !! not use this number.
  subroutine place_of_number(bc, table, place)
    type(boundary_t), intent(in) :: bc
    integer, intent(in) :: table
    type(place_t), intent(out) :: place
    integer :: i

    if (.not. allocated(bc%number)) return
    do i = 1, size(bc%number)
      if (bc%number(i)%table == table) place = bc%number(i)%place
    end do
  end subroutine place_of_number

end module boundary
