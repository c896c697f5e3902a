!> Checks that the elements of a mesh file have known shapes and positive Jacobians.
module mesh_check
  use base_kinds, only: wp
  use base_error, only: error_t
  use base_sort, only: unique
  use base_text, only: to_text
  use element_type, only: rule_t
  use format_text, only: text_t, fail_in_file
  use mesh_file, only: mesh_file_t
  use mesh_shape, only: shape_hint
  use tensor, only: det3
  implicit none
  private
  public :: check_shapes, check_elements

  !> A Jacobian of the map from the reference element is taken as zero if its absolute value is at
  !! most this fraction of L^3, where L is the longest edge of the bounding box of the element: such
  !! a small value may come from the rounding of the coordinates.
  real(wp), parameter :: FLAT = 1.0e-12_wp

contains

  !> Check that the file has solid elements, and that the table of elements contains their shapes.
  subroutine check_shapes(file, text, error)
    type(mesh_file_t), intent(in) :: file
    type(text_t), intent(inout) :: text
    type(error_t), allocatable, intent(out) :: error
    integer :: e

    do e = 1, file%nelem
      associate (shape => file%shapes(file%shape(e)))
        if (.not. file%solid(e) .or. shape%row%name /= '') cycle
        text%at = file%spot(e)
        call fail_in_file(text, 'element '//to_text(file%label(e))//' is a '//trim(shape%name) &
                          //' with '//to_text(shape%nen)//' nodes', error, shape_hint(file%shapes))
      end associate
      return
    end do
    if (any(file%solid)) return
    text%at = 0
    call fail_in_file(text, 'the file has no solid elements', error, 'generate a 3D mesh in ' &
                      //'Gmsh; if the model has physical groups, the volume must belong to one ' &
                      //'of them')
  end subroutine check_shapes

  !> Check that the nodes of each element are distinct, and that the map of the element is
  !! right-handed at all integration points. The map from the reference element is checked, because
  !! the map from the parent cube of a collapsed element is nearly singular where the cube is
  !! collapsed. The volume of the body is computed as well.
  subroutine check_elements(file, text, volume, error)
    type(mesh_file_t), intent(in) :: file
    type(text_t), intent(inout) :: text
    real(wp), intent(out) :: volume          !! volume of the body [L^3]
    type(error_t), allocatable, intent(out) :: error
    type(rule_t) :: rule
    character(:), allocatable :: name
    real(wp), allocatable :: x(:, :), shp(:), dshp(:, :, :), full(:)
    real(wp) :: least, det, extent
    integer :: e, q, s

    volume = 0.0_wp
    do s = 1, size(file%shapes)
      if (file%shapes(s)%row%name == '' .or. .not. any(file%shape(:file%nelem) == s)) cycle
      associate (row => file%shapes(s)%row, cell => file%shapes(s)%cell, &
                 xr => file%shapes(s)%topology%xr)
        call row%rule(cell, 0, 0, rule)
        shp = [(0.0_wp, q=1, file%shapes(s)%nen)]
        full = [(0.0_wp, q=1, rule%nq)]
        if (allocated(dshp)) deallocate (dshp)
        allocate (dshp(3, size(shp), rule%nq))
        do q = 1, rule%nq
          call row%functions(cell, rule%xi(:, q), shp, dshp(:, :, q))
          full(q) = abs(det3(matmul(xr, transpose(dshp(:, :, q)))))
        end do
      end associate
      do e = 1, file%nelem
        if (file%shape(e) /= s .or. .not. file%solid(e)) cycle
        text%at = file%spot(e)
        associate (node => file%node(file%first(e):file%first(e + 1) - 1))
          if (size(unique(node)) < size(node)) then
            call fail_in_file(text, 'element '//to_text(file%label(e))//' lists the same node ' &
                              //'twice', error, 'remove the element, or write a collapsed ' &
                              //'hexahedron as a wedge, pyramid or tetrahedron')
            return
          end if
          x = file%x(:, node)
        end associate
        least = huge(least)
        do q = 1, rule%nq
          det = det3(matmul(x, transpose(dshp(:, :, q))))
          least = min(least, det/full(q))
          volume = volume + rule%wgt(q)*det
        end do
        extent = maxval(maxval(x, 2) - minval(x, 2))
        if (least > FLAT*extent**3) cycle
        name = trim(file%shapes(s)%name)//' '//to_text(file%label(e))
        if (least > -FLAT*extent**3) then
          call fail_in_file(text, name//' has no volume', error, 'all of its nodes lie in one ' &
                            //'plane: remove the element, or generate the mesh again')
        else
          call fail_in_file(text, name//' is inverted', error, 'number the corners of its ' &
                            //'lower face (1 2 3 or 1 2 3 4) counter-clockwise as seen from its ' &
                            //'other corners; if they are already so, the element is distorted: ' &
                            //'improve the mesh, or make curved elements straight (in Gmsh: ' &
                            //'Mesh.ElementOrder = 1)')
        end if
        return
      end do
    end do
  end subroutine check_elements

end module mesh_check
