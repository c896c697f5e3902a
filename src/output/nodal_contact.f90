!> Fields of all contacts at the nodes.
!!
!! A node may belong to several sides. Two contacts on the same faces both load them, so that their
!! tractions add up. Two contacts on neighbouring faces each load only a part of the area round a
!! common node. The traction of all sides is therefore
!!
!!   T_A = sum_s T_A^s a_A^s / a_A
!!
!! where T_A^s is the smooth traction of side s (contact_smooth), a_A^s = int N_A da is taken over
!! the faces of this side, and a_A over all faces of contacts at the node, each counted once. The
!! same holds for pressures and slips.
module nodal_contact
  use base_kinds, only: wp, i8
  use base_sort, only: sort_index
  use contact_pair, only: contact_t, contact_state_t, surface_t, is_integrated
  use contact_smooth, only: smooth_t, smooth_side, find_areas
  implicit none
  private
  public :: nodal_contact_t, gather_contact

  !> Coefficients of the fields of contact. If a node belongs to several sides, the tractions,
  !! pressures and slips are those above, and the smallest gap and the largest state are taken.
  type :: nodal_contact_t
    real(wp), allocatable :: traction(:, :) !! (3, nnode) on the surface [F/L^2]
    real(wp), allocatable :: friction(:, :) !! (3, nnode) the part due to friction [F/L^2]
    real(wp), allocatable :: pressure(:, :) !! (1, nnode) [F/L^2]
    real(wp), allocatable :: gap(:, :)      !! (1, nnode) [L]
    real(wp), allocatable :: slip(:, :)     !! (3, nnode) [L]
    real(wp), allocatable :: state(:, :)    !! (1, nnode) 0 open, 1 stick, 2 slip
    logical, allocatable :: met(:)          !! (nnode) the node is on a side that has been smoothed
  end type nodal_contact_t

  !> The areas of one side.
  type :: areas_t
    real(wp), allocatable :: area(:) !! (size(surface%node)) see find_areas [L^2]
    logical, allocatable :: again(:) !! (nelem) another side has this face, too, and comes first
  end type areas_t

contains

  !> Smooth the fields of all sides of all contacts. A side that is not integrated has no points,
  !! and its fields stay zero. A node near which no point has a projection is given the largest gap
  !! of its contacts or, if nothing faces them, of all contacts.
  subroutine gather_contact(contact, state, nnode, nodal)
    type(contact_t), intent(in) :: contact(:)
    type(contact_state_t), intent(in) :: state(:) !! (size(contact))
    integer, intent(in) :: nnode
    type(nodal_contact_t), intent(out) :: nodal
    type(areas_t) :: areas(2, size(contact))
    type(smooth_t) :: field
    real(wp), allocatable :: whole(:)    !! (nnode) area of all faces at a node [L^2]
    real(wp), allocatable :: own(:)      !! (nnode) area of the faces of one side [L^2]
    real(wp), allocatable :: far(:)      !! (nnode) largest gap of the contacts at a node [L]
    logical, allocatable :: faces(:)     !! (nnode) the gap is that of points near the node
    real(wp) :: share
    integer :: a, c, k, n

    allocate (nodal%traction(3, nnode), nodal%friction(3, nnode), nodal%slip(3, nnode), &
              nodal%pressure(1, nnode), nodal%gap(1, nnode), nodal%state(1, nnode), source=0.0_wp)
    allocate (nodal%met(nnode), faces(nnode), source=.false.)
    allocate (own(nnode), whole(nnode), source=0.0_wp)
    allocate (far(nnode), source=-huge(1.0_wp))
    call list_areas(contact, state, areas)
    do c = 1, size(contact)
      do k = 1, 2
        if (.not. is_integrated(contact(c), k)) cycle
        call add_areas(contact(c)%side(k), areas(k, c), whole, areas(k, c)%again)
      end do
    end do
    do c = 1, size(contact)
      do k = 1, 2
        if (.not. is_integrated(contact(c), k)) cycle
        call smooth_side(contact(c), k, state(c)%side(k), field, state(c)%side(3 - k))
        own(field%node) = 0.0_wp
        call add_areas(contact(c)%side(k), areas(k, c), own)
        do a = 1, size(field%node)
          n = field%node(a)
          share = 1.0_wp
          if (whole(n) > 0.0_wp) share = own(n)/whole(n)
          nodal%traction(:, n) = nodal%traction(:, n) + share*field%traction(:, a)
          nodal%friction(:, n) = nodal%friction(:, n) + share*field%friction(:, a)
          nodal%pressure(1, n) = nodal%pressure(1, n) + share*field%pressure(a)
          nodal%slip(:, n) = nodal%slip(:, n) + share*field%slip(:, a)
          nodal%state(1, n) = max(nodal%state(1, n), field%state(a))
          nodal%met(n) = .true.
          if (field%faces(a)) then
            nodal%gap(1, n) = merge(min(nodal%gap(1, n), field%gap(a)), field%gap(a), faces(n))
            faces(n) = .true.
          else if (any(field%faces)) then
            far(n) = max(far(n), field%gap(a))
          end if
        end do
      end do
    end do
    call fill_gaps(nodal%met, faces, far, nodal%gap(1, :))
  end subroutine gather_contact

  !> Give a gap to the nodes near which no point has a projection.
  pure subroutine fill_gaps(met, faces, far, gap)
    logical, intent(in) :: met(:), faces(:)
    real(wp), intent(in) :: far(:)         !! the largest gap of the contacts; -huge: there is none
    real(wp), intent(inout) :: gap(:)
    real(wp) :: largest

    largest = 0.0_wp
    if (any(faces)) largest = maxval(gap, mask=faces)
    where (met .and. .not. faces) gap = merge(far, largest, far > -huge(1.0_wp))
  end subroutine fill_gaps

  !> Find the areas of all integrated sides, and the faces that belong to several of them. Equal
  !! faces get equal areas, because those found from different integration points differ slightly.
  subroutine list_areas(contact, state, areas)
    type(contact_t), intent(in) :: contact(:)
    type(contact_state_t), intent(in) :: state(:)
    type(areas_t), intent(inout) :: areas(:, :) !! (2, size(contact))
    integer, parameter :: NFACE = 8      !! more than the number of faces of an element
    integer(i8), allocatable :: key(:)   !! the same for equal faces
    integer, allocatable :: owner(:, :)  !! (3, n) contact, side and element in it
    integer, allocatable :: order(:)
    integer :: c, e, f, i, k, n, nblock

    n = 0
    nblock = 0
    do c = 1, size(contact)
      do k = 1, 2
        if (.not. is_integrated(contact(c), k)) cycle
        associate (side => contact(c)%side(k), mine => areas(k, c))
          n = n + side%nelem
          nblock = max(nblock, maxval(side%block))
          allocate (mine%area(size(side%node)))
          allocate (mine%again(side%nelem), source=.false.)
          call find_areas(contact(c), k, state(c)%side(k), mine%area)
        end associate
      end do
    end do
    allocate (key(n), order(n), owner(3, n))
    n = 0
    do c = 1, size(contact)
      do k = 1, 2
        if (.not. is_integrated(contact(c), k)) cycle
        associate (side => contact(c)%side(k))
          do e = 1, side%nelem
            n = n + 1
            key(n) = NFACE*(int(side%elem(e), i8)*(nblock + 1) + side%block(e)) + side%face(e)
            owner(:, n) = [c, k, e]
          end do
        end associate
      end do
    end do
    call sort_index(key, order) ! equal keys keep their order
    f = 1
    do i = 2, n
      if (key(order(i)) /= key(order(f))) then
        f = i
      else
        call copy_areas(contact, owner(:, order(f)), owner(:, order(i)), areas)
      end if
    end do
  end subroutine list_areas

  !> Copy the areas of a face to another side that has this face, too.
  pure subroutine copy_areas(contact, from, to, areas)
    type(contact_t), intent(in) :: contact(:)
    integer, intent(in) :: from(3), to(3)  !! contact, side and element in it
    type(areas_t), intent(inout) :: areas(:, :)

    associate (first_from => contact(from(1))%side(from(2))%first(from(3)), &
               first_to => contact(to(1))%side(to(2))%first(to(3)), &
               next_to => contact(to(1))%side(to(2))%first(to(3) + 1), &
               theirs => areas(from(2), from(1)), mine => areas(to(2), to(1)))
      mine%again(to(3)) = .true.
      mine%area(first_to:next_to - 1) = theirs%area(first_from:first_from + next_to - first_to - 1)
    end associate
  end subroutine copy_areas

  !> Add the areas of the faces of a side at their nodes.
  pure subroutine add_areas(surface, areas, area, leave)
    type(surface_t), intent(in) :: surface
    type(areas_t), intent(in) :: areas
    real(wp), intent(inout) :: area(:)   !! (nnode) [L^2]
    logical, intent(in), optional :: leave(:) !! (nelem) faces that are not added
    integer :: e, i

    do e = 1, surface%nelem
      if (present(leave)) then
        if (leave(e)) cycle
      end if
      do i = surface%first(e), surface%first(e + 1) - 1
        area(surface%node(i)) = area(surface%node(i)) + areas%area(i)
      end do
    end do
  end subroutine add_areas

end module nodal_contact
