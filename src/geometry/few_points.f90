!> Warnings about QUADrature and NURB interp with fewer integration points than the elements of a
!! body need. Such elements can deform without any strain at their points (hourglass modes).
!!
!! Lagrange functions need degree + 1 points in each direction. Splines share functions between
!! elements and can need fewer. In one direction, the values at the points determine a spline if
!! there are at least as many points as functions; the number of functions that exceeds the number
!! of points is the shortage of this direction. Ranks of patches of 1 to 4 elements in each
!! direction, with degrees 1 to 3 and 1 to 4 points, show that there are hourglass modes if the sum
!! of the shortages of all directions is at least 2 (for instance 27 modes for one quadratic element
!! with 2 x 2 x 2 points, but none for two elements in each direction), or if there is only one
!! point in a direction.
module few_points
  use base_error, only: place_t
  use base_log, only: warn
  use base_text, only: quoted, to_text
  use patch_spec, only: patch_spec_t
  implicit none
  private
  public :: warn_few_points, warn_few_nurbs_points, splines_lack_points

contains

  !> Have splines fewer integration points than they need?
  pure logical function splines_lack_points(points, functions, elements) result(lack)
    integer, intent(in) :: points(:)    !! (nd) points of an element in each direction
    integer, intent(in) :: functions(:) !! (nd) functions of the patch in each direction
    integer, intent(in) :: elements(:)  !! (nd) elements of the patch in each direction
    integer :: shortage(size(points))

    shortage = max(0, functions - points*elements)
    lack = sum(shortage) > 1 .or. any(shortage > 0 .and. points == 1)
  end function splines_lack_points

  !> Warn that the elements `name` of a body have too few integration points.
  subroutine warn_few_points(spec, name, enough)
    type(patch_spec_t), intent(in) :: spec
    character(*), intent(in) :: name
    character(*), intent(in) :: enough  !! numbers of points that suffice
    character(:), allocatable :: text

    text = 'QUADrature '//to_text(spec%q)
    if (spec%qz > 0) text = text//' '//to_text(spec%qz)
    call warn_points(text, name, spec%name, spec%place, 'use '//enough//', or omit QUADrature')
  end subroutine warn_few_points

  !> Warn if NURB interp of the material gives the elements of an NPATch too few integration points.
  subroutine warn_few_nurbs_points(points, degree, functions, elements, body, place)
    integer, intent(in) :: points(3), degree(3)
    integer, intent(in) :: functions(3), elements(3) !! of the NPATch, in each direction
    character(*), intent(in) :: body
    type(place_t), intent(in) :: place
    character(:), allocatable :: enough
    integer :: d

    if (.not. splines_lack_points(points, functions, elements)) return
    enough = 'NURB interp'
    do d = 1, 3
      enough = enough//' '//to_text(degree(d) + 1)
    end do
    call warn_points('NURB interp '//to_text(points(1))//' '//to_text(points(2))//' ' &
                     //to_text(points(3)), 'IGA'//to_text(maxval(degree)), body, place, &
                     'use '//enough//', or omit NURB interp')
  end subroutine warn_few_nurbs_points

  subroutine warn_points(points, element, body, place, hint)
    character(*), intent(in) :: points   !! the option and its numbers
    character(*), intent(in) :: element, body, hint
    type(place_t), intent(in) :: place

    call warn(points//' has too few integration points for '//trim(element)//' elements of ' &
              //quoted(body)//': they can deform without strain energy (hourglass modes), ' &
              //'and their stresses may be meaningless', place, hint)
  end subroutine warn_points

end module few_points
