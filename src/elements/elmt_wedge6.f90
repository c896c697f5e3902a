!> WEDGE6: six-node wedge, linear on its triangles and along its height.
!!
!! Nodes:  lower triangle counter-clockwise seen from the upper one, then the upper (FEAP and Gmsh)
!! Parent: cube whose face eta+ is an edge, see collapsed_shape
!! Rule:   2 x 2 x 2 points of the cube
!! Source: Zienkiewicz and Taylor 2005
!! Limits: locks like Q1
module elmt_wedge6
  use base_kinds, only: wp
  use collapsed_shape, only: fold_triangle, collapsed_rule
  use element_type, only: element_t, cell_t, topology_t
  use hexa_shape, only: linear, join_faces
  use solid_form, only: form
  implicit none
  private
  public :: describe

  integer, parameter :: VTK_WEDGE = 13

contains

  !> Row of this element in the table of elements.
  function describe() result(row)
    type(element_t) :: row

    row = element_t(name='WEDGE6', deck_nodes=6, degree=1, source='linear wedge, 6 nodes', &
                    rule=collapsed_rule, functions=functions, topology=set_topology, form=form)
  end function describe

  pure subroutine functions(cell, xi, shp, dshp)
    type(cell_t), intent(in) :: cell
    real(wp), intent(in) :: xi(3)
    real(wp), intent(out) :: shp(:)     !! (6)
    real(wp), intent(out) :: dshp(:, :) !! (3, 6)
    real(wp) :: v(3), dv(2, 3), f(2), d(2)
    integer :: a, k

    associate (unused => cell); end associate
    call fold_triangle(xi(:2), v, dv)
    call linear(xi(3), f, d)
    do k = 1, 2
      do a = 1, 3
        shp(3*k - 3 + a) = v(a)*f(k)
        dshp(:2, 3*k - 3 + a) = dv(:, a)*f(k)
        dshp(3, 3*k - 3 + a) = v(a)*d(k)
      end do
    end do
  end subroutine functions

  !> Set the faces: three quadrilaterals, an edge and two triangles. The triangles of VTK have the
  !! opposite orientation.
  subroutine set_topology(cell, topology)
    type(cell_t), intent(in) :: cell
    type(topology_t), intent(out) :: topology
    logical :: on(6, 6)

    associate (unused => cell); end associate
    on = .false.
    on([1, 3, 4, 6], 1) = .true.
    on([2, 3, 5, 6], 2) = .true.
    on([1, 2, 4, 5], 3) = .true.
    on([3, 6], 4) = .true.
    on([1, 2, 3], 5) = .true.
    on([4, 5, 6], 6) = .true.
    call join_faces(on, topology)
    topology%vtk = VTK_WEDGE
    topology%vtk_node = [1, 3, 2, 4, 6, 5]
    topology%shape = 'wedge'
    topology%corner = [1, 2, 3, 4, 5, 6]
    topology%xr = reshape([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1], [3, 6])*1.0_wp
    topology%gmsh = 6
  end subroutine set_topology

end module elmt_wedge6
