!> Nodes and elements of a FEAP mesh while the deck is read: lists that grow with their numbers.
module input_lists
  use base_kinds, only: wp
  use base_error, only: place_t
  implicit none
  private
  public :: node_list_t, element_list_t, mention_list_t, place_list_t, grow_nodes, grow_elements, &
            add_place, add_mention

  integer, parameter, public :: MAX_NUMBER = 50000000 !! nodes or elements of one mesh

  !> Nodes 1 to `top`; those that were not given leave holes.
  type :: node_list_t
    integer :: top = 0                       !! largest number with a position
    real(wp), allocatable :: x(:, :)         !! (3, n) [L]
    logical, allocatable :: given(:)         !! (n)
    real(wp), allocatable :: weight(:)       !! (n) of control points; 0: a node
    integer, allocatable :: code(:, :)       !! (3, n) BOUN
    real(wp), allocatable :: force(:, :)     !! (3, n) FORC [F]
    real(wp), allocatable :: value(:, :)     !! (3, n) DISP [L]
    integer, allocatable :: table(:, :)      !! (3, n) FPRO
    type(place_t) :: disp                    !! the first record of DISP
  end type node_list_t

  !> Elements 1 to `top`.
  type :: element_list_t
    integer :: top = 0
    integer, allocatable :: node(:, :)       !! (8 or 27, n) in FEAP's order
    integer, allocatable :: nen(:)           !! (n) 0: not given
    integer, allocatable :: material(:)      !! (n) the user's number
    integer, allocatable :: place(:)         !! (n) index into the list of places
  end type element_list_t

  !> Places of records that made elements.
  type :: place_list_t
    integer :: n = 0
    type(place_t), allocatable :: at(:)
  end type place_list_t

  !> Nodes that records name before they are known to exist.
  type :: mention_list_t
    integer, allocatable :: node(:) !! (>= place%n)
    type(place_list_t) :: place
  end type mention_list_t

contains

  !> Room for node n.
  subroutine grow_nodes(list, n)
    type(node_list_t), intent(inout) :: list
    integer, intent(in) :: n
    integer :: old, new

    old = 0
    if (allocated(list%given)) old = size(list%given)
    if (n <= old) return
    new = max(n, min(2*old, MAX_NUMBER), 64)
    call grow_reals(list%x, old, new)
    call grow_reals(list%force, old, new)
    call grow_reals(list%value, old, new)
    call grow_integers(list%code, 3, old, new)
    call grow_integers(list%table, 3, old, new)
    block
      logical, allocatable :: given(:)
      real(wp), allocatable :: weight(:)

      allocate (given(new), source=.false.)
      allocate (weight(new), source=0.0_wp)
      if (old > 0) given(:old) = list%given
      if (old > 0) weight(:old) = list%weight
      call move_alloc(given, list%given)
      call move_alloc(weight, list%weight)
    end block
  end subroutine grow_nodes

  !> Room for element n with nen nodes.
  subroutine grow_elements(list, n, nen)
    type(element_list_t), intent(inout) :: list
    integer, intent(in) :: n, nen
    integer :: old, new, rows

    old = 0
    rows = merge(8, 27, nen <= 8)
    if (allocated(list%nen)) then
      old = size(list%nen)
      rows = max(rows, size(list%node, 1))
      if (n <= old .and. rows == size(list%node, 1)) return
    end if
    new = old
    if (n > old) new = max(n, min(2*old, MAX_NUMBER), 64)
    call grow_integers(list%node, rows, old, new)
    call grow_list(list%nen, old, new)
    call grow_list(list%material, old, new)
    call grow_list(list%place, old, new)
  end subroutine grow_elements

  subroutine grow_reals(a, old, new)
    real(wp), allocatable, intent(inout) :: a(:, :)
    integer, intent(in) :: old, new
    real(wp), allocatable :: b(:, :)

    allocate (b(3, new), source=0.0_wp)
    if (old > 0) b(:, :old) = a
    call move_alloc(b, a)
  end subroutine grow_reals

  subroutine grow_integers(a, rows, old, new)
    integer, allocatable, intent(inout) :: a(:, :)
    integer, intent(in) :: rows, old, new
    integer, allocatable :: b(:, :)

    allocate (b(rows, new), source=0)
    if (old > 0) b(:size(a, 1), :old) = a
    call move_alloc(b, a)
  end subroutine grow_integers

  subroutine grow_list(a, old, new)
    integer, allocatable, intent(inout) :: a(:)
    integer, intent(in) :: old, new
    integer, allocatable :: b(:)

    allocate (b(new), source=0)
    if (old > 0) b(:old) = a
    call move_alloc(b, a)
  end subroutine grow_list

  !> One more place.
  subroutine add_place(list, place)
    type(place_list_t), intent(inout) :: list
    type(place_t), intent(in) :: place
    type(place_t), allocatable :: longer(:)
    integer :: i

    if (.not. allocated(list%at)) allocate (list%at(16))
    if (list%n == size(list%at)) then
      allocate (longer(2*list%n))
      do i = 1, list%n
        if (allocated(list%at(i)%file)) call move_alloc(list%at(i)%file, longer(i)%file)
        if (allocated(list%at(i)%text)) call move_alloc(list%at(i)%text, longer(i)%text)
        longer(i)%line = list%at(i)%line
        longer(i)%column = list%at(i)%column
        longer(i)%width = list%at(i)%width
      end do
      call move_alloc(longer, list%at)
    end if
    list%n = list%n + 1
    list%at(list%n) = place
  end subroutine add_place

  !> One more node to be looked for at the end.
  subroutine add_mention(list, node, place)
    type(mention_list_t), intent(inout) :: list
    integer, intent(in) :: node
    type(place_t), intent(in) :: place
    integer :: n

    call add_place(list%place, place)
    n = list%place%n
    if (.not. allocated(list%node)) allocate (list%node(0))
    if (n > size(list%node)) call grow_list(list%node, size(list%node), size(list%place%at))
    list%node(n) = node
  end subroutine add_mention

end module input_lists
