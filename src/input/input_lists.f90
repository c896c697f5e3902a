!> Nodes and elements of a FEAP mesh while the deck is read: lists that grow with the numbers.
!!
!! A deck may give numbers in any order, and may leave some out.
module input_lists
  use base_error, only: place_t
  use base_grow, only: grow
  use base_kinds, only: wp
  implicit none
  private
  public :: node_list_t, element_list_t, named_nodes_t, place_list_t, grow_nodes, grow_elements, &
            add_place, add_named_node

  integer, parameter, public :: MAX_NUMBER = 50000000 !! the largest number that a node or an
  !! element may have

  !> Nodes 1 to `top`; `given` is false for numbers that the deck leaves out.
  type :: node_list_t
    integer :: top = 0                       !! largest number with a position
    real(wp), allocatable :: x(:, :)         !! (3, n) [L]
    logical, allocatable :: given(:)         !! (n)
    real(wp), allocatable :: weight(:)       !! (n) weight of a control point; 0: an ordinary node
    integer, allocatable :: code(:, :)       !! (3, n) BOUN
    real(wp), allocatable :: force(:, :)     !! (3, n) FORC [F]
    !> (n) bit k is set if a record of BOUN, DISP, FORC or FPRO (k = C_FIXED to C_TABLE) names the
    !! node; nodes that generation finds between two records are not named.
    integer, allocatable :: named(:)
    real(wp), allocatable :: value(:, :)     !! (3, n) DISP [L]
    integer, allocatable :: table(:, :)      !! (3, n) FPRO
    logical, allocatable :: numbered(:)      !! (n) FPRO gives `table`, also by generation
    type(place_t) :: disp                    !! place of the first record of DISP
    !> (4, n) how many records by position (condition_entry_t) precede the last record of BOUN, of
    !! DISP, of FORC and of FPRO that gives the node a value other than 0.
    integer, allocatable :: after(:, :)
  end type node_list_t

  !> Elements 1 to `top`; `nen` is 0 for numbers that the deck leaves out.
  type :: element_list_t
    integer :: top = 0
    integer, allocatable :: node(:, :)       !! (8 or 27, n) nodes in FEAP's order
    integer, allocatable :: nen(:)           !! (n) number of nodes
    integer, allocatable :: material(:)      !! (n) the user's number
    integer, allocatable :: place(:)         !! (n) index into the list of places
  end type element_list_t

  !> Places of the records that generate elements.
  type :: place_list_t
    integer :: n = 0
    type(place_t), allocatable :: at(:)
  end type place_list_t

  !> Nodes that records name, possibly before they are defined.
  type :: named_nodes_t
    integer, allocatable :: node(:) !! (>= place%n)
    type(place_list_t) :: place
  end type named_nodes_t

contains

  !> Make room for node n.
  subroutine grow_nodes(list, n)
    type(node_list_t), intent(inout) :: list
    integer, intent(in) :: n

    call grow(list%x, 3, n)
    call grow(list%given, n)
    call grow(list%weight, n)
    call grow(list%code, 3, n)
    call grow(list%force, 3, n)
    call grow(list%named, n)
    call grow(list%value, 3, n)
    call grow(list%table, 3, n)
    call grow(list%numbered, n)
    call grow(list%after, 4, n)
  end subroutine grow_nodes

  !> Make room for element n with nen nodes.
  subroutine grow_elements(list, n, nen)
    type(element_list_t), intent(inout) :: list
    integer, intent(in) :: n, nen

    call grow(list%node, merge(8, 27, nen <= 8), n)
    call grow(list%nen, n)
    call grow(list%material, n)
    call grow(list%place, n)
  end subroutine grow_elements

  !> Append a place.
  subroutine add_place(list, place)
    type(place_list_t), intent(inout) :: list
    type(place_t), intent(in) :: place

    list%n = list%n + 1
    call grow(list%at, list%n)
    list%at(list%n) = place
  end subroutine add_place

  !> Append a node; whether it exists is checked at the END of the mesh.
  subroutine add_named_node(list, node, place)
    type(named_nodes_t), intent(inout) :: list
    integer, intent(in) :: node
    type(place_t), intent(in) :: place

    call add_place(list%place, place)
    call grow(list%node, list%place%n)
    list%node(list%place%n) = node
  end subroutine add_named_node

end module input_lists
